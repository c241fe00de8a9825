//! An animation at a time: where it puts nodes, and how it weighs morph targets.

use std::collections::HashMap;

use glam::{DQuat, DVec3};

use super::buffers::Buffers;
use super::json::{Animation, Channel, Root};
use super::keys::{Interpolation, Keys};
use super::{at_place, malformed};
use crate::error::{Error, Place, Result};
use crate::load::AnimationTime;
use crate::load::warnings::Warnings;

/// What an animation says of a node at a time, beside what the node says itself.
#[derive(Debug, Default)]
pub(super) struct NodePose {
    pub(super) translation: Option<DVec3>,
    pub(super) rotation: Option<DQuat>,
    pub(super) scale: Option<DVec3>,
    /// Of the morph targets of its mesh.
    pub(super) weights: Option<Vec<f32>>,
}

/// The nodes that are animated, at a time.
#[derive(Debug, Default)]
pub(super) struct Pose(HashMap<usize, NodePose>);

impl Pose {
    /// The pose of an animation of the file.
    pub(super) fn at(
        asked: &AnimationTime,
        buffers: &Buffers<'_>,
        warnings: &mut Warnings,
    ) -> Result<Self> {
        let root = buffers.root;
        let index = choose(root, asked.animation.as_deref())?;
        let place = |error| at_place(error, &format!("animation {index}"));
        let animation = serde_json::from_value::<Animation>(root.animations[index].clone());
        let animation = animation.map_err(|error| place(malformed(error.to_string())))?;
        let mut pose = Self::default();
        for (at, channel) in animation.channels.iter().enumerate() {
            let place = |error| place(at_place(error, &format!("channel {at}")));
            pose.add(channel, &animation, asked.time, buffers, warnings).map_err(place)?;
        }
        Ok(pose)
    }

    /// The pose of a node, if it is animated.
    pub(super) fn of(&self, node: usize) -> Option<&NodePose> {
        self.0.get(&node)
    }

    fn add(
        &mut self,
        channel: &Channel,
        animation: &Animation,
        time: f64,
        buffers: &Buffers<'_>,
        warnings: &mut Warnings,
    ) -> Result<()> {
        if let Some(pointer) = &channel.target.extensions.pointer {
            let path = pointer.pointer.as_str();
            if ["/nodes/", "/meshes/", "/materials/"].iter().any(|place| path.starts_with(place)) {
                warnings.add(format!("its animation of {path:.80} is not applied"));
            }
            return Ok(());
        }
        // Without a node, and with a path of an extension, a channel is to be left out.
        let Some(node) = channel.target.node.map(|node| node.0) else { return Ok(()) };
        let Some(stated) = buffers.root.nodes.get(node) else {
            return Err(malformed(format!("no node {node}")));
        };
        let Some(sampler) = animation.samplers.get(channel.sampler.0) else {
            return Err(malformed(format!("no sampler {}", channel.sampler.0)));
        };
        let interpolation = Interpolation::of(sampler.interpolation.as_deref())?;
        let times = buffers.floats::<1>(sampler.input.0)?;
        let keys = Keys::new(&times, time, interpolation)?;
        let output = sampler.output.0;
        let path = channel.target.path.as_str();
        let place = |error| at_place(error, &format!("the {path} of node {node}"));
        if path != "weights" && stated.matrix.is_some() {
            return Err(place(malformed("a node with a matrix can't be animated".to_owned())));
        }
        let pose = self.0.entry(node).or_default();
        match path {
            "translation" | "scale" => {
                let values = keys.values(&buffers.floats::<3>(output)?).map_err(place)?;
                let value = Some(DVec3::from(values));
                *(if path == "scale" { &mut pose.scale } else { &mut pose.translation }) = value;
            }
            "rotation" => {
                let rotation = keys.rotation(&buffers.fractions::<4>(output)?);
                pose.rotation = Some(rotation.map_err(place)?);
            }
            "weights" => {
                let targets = stated
                    .mesh
                    .and_then(|mesh| buffers.root.meshes.get(mesh.0)?.primitives.first())
                    .map_or(0, |primitive| primitive.targets.len());
                let values: Vec<[f32; 1]> = buffers.fractions::<1>(output)?;
                pose.weights = Some(keys.weights(&values, targets).map_err(place)?);
            }
            path => {
                warnings.add(format!("its animation of {path:.80} is not applied"));
            }
        }
        Ok(())
    }
}

/// The index of the animation of a name, or of a number if none has that name; of the
/// only one where none is named.
fn choose(root: &Root, name: Option<&str>) -> Result<usize> {
    let names: Vec<&str> = root
        .animations
        .iter()
        .map(|animation| animation.get("name").and_then(|name| name.as_str()).unwrap_or_default())
        .collect();
    let listed = || {
        let mut listed: Vec<String> = names.iter().take(16).map(|n| format!("'{n:.60}'")).collect();
        listed.extend((names.len() > 16).then(|| format!("and {} more", names.len() - 16)));
        listed.join(", ")
    };
    let refuse = |reason| Err(Error::malformed(Place::Named("animation".into()), reason));
    let Some(name) = name else {
        return match names.len() {
            0 => refuse("the file has none".to_owned()),
            1 => Ok(0),
            _ => refuse(format!("which one, by name or by number from 0? There are {}", listed())),
        };
    };
    let mut called = (0..names.len()).filter(|&index| names[index] == name);
    match (called.next(), called.next()) {
        (Some(_), Some(_)) => {
            refuse(format!("several are called '{name:.60}': choose by number from 0"))
        }
        (Some(index), None) => Ok(index),
        (None, _) => match name.parse::<usize>() {
            Ok(index) if index < names.len() => Ok(index),
            _ if names.is_empty() => refuse("the file has none".to_owned()),
            _ => refuse(format!("none is called '{name:.60}': there are {}", listed())),
        },
    }
}
