//! The tree of nodes: what is drawn, and where every node stands.

use glam::{DMat4, DVec3};

use super::buffers::Buffers;
use super::json::{Node, Root};
use super::keys::rotation_of;
use super::pose::{NodePose, Pose};
use super::{at_place, malformed};
use crate::error::{Error, Place, Result};

/// The nodes of a file in the world.
pub(super) struct Nodes<'a> {
    root: &'a Root,
    pose: &'a Pose,
    /// Node to world; none of those in no tree.
    world: Vec<Option<DMat4>>,
    /// The nodes of the default scene that are seen, in the order of the tree.
    pub(super) drawn: Vec<usize>,
}

impl<'a> Nodes<'a> {
    /// Places all nodes of the default scene, else the first, and those of other trees,
    /// on which joints may stand.
    pub(super) fn place(root: &'a Root, pose: &'a Pose) -> Result<Self> {
        let world = vec![None; root.nodes.len()];
        let mut nodes = Self { root, pose, world, drawn: Vec::new() };
        let scene = root.scene.map_or(0, |scene| scene.0);
        match root.scenes.get(scene) {
            Some(scene) => {
                for node in &scene.nodes {
                    nodes.place_tree(node.0, true)?;
                }
            }
            None if root.scene.is_some() => return Err(malformed(format!("no scene {scene}"))),
            None => {}
        }
        let mut is_child = vec![false; root.nodes.len()];
        for child in root.nodes.iter().flat_map(|node| &node.children) {
            if let Some(is_child) = is_child.get_mut(child.0) {
                *is_child = true;
            }
        }
        for (index, is_child) in is_child.into_iter().enumerate() {
            if !is_child && nodes.world[index].is_none() {
                nodes.place_tree(index, false)?;
            }
        }
        Ok(nodes)
    }

    fn place_tree(&mut self, top: usize, is_drawn: bool) -> Result<()> {
        let mut open = vec![(top, DMat4::IDENTITY, is_drawn)];
        while let Some((index, parent, is_seen)) = open.pop() {
            let Some(node) = self.root.nodes.get(index) else {
                return Err(malformed(format!("no node {index}")));
            };
            let place = || Place::Named(format!("node {index}"));
            if self.world[index].is_some() {
                // A tree that no scene has may hang on one that is placed.
                if !is_drawn {
                    continue;
                }
                return Err(Error::malformed(place(), "occurs twice in the tree"));
            }
            let world = parent * local(node, self.pose.of(index));
            self.world[index] = Some(world);
            let is_visible = node.extensions.visibility.as_ref().is_none_or(|at| at.visible);
            let is_seen = is_seen && is_visible;
            if is_seen {
                self.drawn.push(index);
            }
            open.extend(node.children.iter().rev().map(|child| (child.0, world, is_seen)));
        }
        Ok(())
    }

    /// Node to world.
    pub(super) fn world(&self, index: usize) -> Result<DMat4> {
        let world = self.world.get(index).copied().flatten();
        world.ok_or_else(|| malformed(format!("node {index} is in no tree")))
    }

    /// The weights of the morph targets of a node's mesh, if the node or its animation
    /// has some.
    pub(super) fn weights(&self, index: usize) -> Option<&'a Vec<f32>> {
        let animated = self.pose.of(index).and_then(|pose| pose.weights.as_ref());
        animated.or(self.root.nodes[index].weights.as_ref())
    }

    /// The places of a node's mesh in the world: one, or those of its instances.
    pub(super) fn instances(&self, index: usize, buffers: &Buffers<'_>) -> Result<Vec<DMat4>> {
        let world = self.world(index)?;
        let Some(instancing) = &self.root.nodes[index].extensions.instancing else {
            return Ok(vec![world]);
        };
        let attribute = |name: &str| instancing.attributes.get(name).map(|at| at.0);
        let instances = || {
            let translations = attribute("TRANSLATION").map(|at| buffers.floats::<3>(at));
            let rotations = attribute("ROTATION").map(|at| buffers.fractions::<4>(at));
            let scales = attribute("SCALE").map(|at| buffers.floats::<3>(at));
            let translations = translations.transpose()?;
            let (rotations, scales) = (rotations.transpose()?, scales.transpose()?);
            let counts = [
                translations.as_ref().map(Vec::len),
                rotations.as_ref().map(Vec::len),
                scales.as_ref().map(Vec::len),
            ];
            let mut counts = counts.into_iter().flatten();
            let count = counts.next().unwrap_or(0);
            if counts.any(|other| other != count) {
                return Err(malformed("instances need as many of each attribute".to_owned()));
            }
            let instance = |at: usize| {
                let translation = translations.as_ref().map_or([0.0; 3], |all| all[at]);
                let rotation = rotations.as_ref().map_or([0.0, 0.0, 0.0, 1.0], |all| all[at]);
                let scale = scales.as_ref().map_or([1.0; 3], |all| all[at]);
                world
                    * DMat4::from_scale_rotation_translation(
                        DVec3::from(scale.map(f64::from)),
                        rotation_of(rotation.map(f64::from)),
                        DVec3::from(translation.map(f64::from)),
                    )
            };
            Ok((0..count).map(instance).collect())
        };
        instances().map_err(|error| at_place(error, &format!("node {index}, its instances")))
    }
}

/// Node to parent.
fn local(node: &Node, pose: Option<&NodePose>) -> DMat4 {
    if let Some(matrix) = &node.matrix {
        return DMat4::from_cols_array(matrix);
    }
    let scale = pose.and_then(|pose| pose.scale);
    let rotation = pose.and_then(|pose| pose.rotation);
    let translation = pose.and_then(|pose| pose.translation);
    DMat4::from_scale_rotation_translation(
        scale.unwrap_or_else(|| DVec3::from(node.scale.unwrap_or([1.0; 3]))),
        rotation.unwrap_or_else(|| rotation_of(node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]))),
        translation.unwrap_or_else(|| DVec3::from(node.translation.unwrap_or_default())),
    )
}
