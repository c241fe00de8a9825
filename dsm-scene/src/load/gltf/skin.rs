//! Skins: vertices that follow joints.

use glam::{DMat4, DVec3};

use super::buffers::Buffers;
use super::json::Primitive;
use super::malformed;
use super::nodes::Nodes;
use crate::error::Result;

/// The matrices that bring vertices from where they were bound to the world, one a
/// joint.
pub(super) struct Skin(Vec<DMat4>);

impl Skin {
    pub(super) fn load(index: usize, nodes: &Nodes<'_>, buffers: &Buffers<'_>) -> Result<Self> {
        let Some(skin) = buffers.root.skins.get(index) else {
            return Err(malformed(format!("no skin {index}")));
        };
        let unbind = match skin.inverse_bind_matrices {
            Some(accessor) => buffers.floats::<16>(accessor.0)?,
            None => vec![DMat4::IDENTITY.as_mat4().to_cols_array(); skin.joints.len()],
        };
        if unbind.len() < skin.joints.len() {
            return Err(malformed(format!("skin {index} has a matrix for some joints only")));
        }
        let joints = skin.joints.iter().zip(unbind);
        let matrix = |(joint, unbind): (&super::json::Whole, [f32; 16])| {
            Ok(nodes.world(joint.0)? * DMat4::from_cols_array(&unbind.map(f64::from)))
        };
        joints.map(matrix).collect::<Result<_>>().map(Self)
    }

    /// The vertices in the world; `None` if the primitive has no joints.
    pub(super) fn place(
        &self,
        primitive: &Primitive,
        positions: &[[f32; 3]],
        buffers: &Buffers<'_>,
    ) -> Result<Option<Vec<DVec3>>> {
        let mut blended = vec![(DMat4::ZERO, 0.0_f64); positions.len()];
        for set in 0.. {
            let attribute = |name: &str| {
                primitive.attributes.get(&format!("{name}_{set}")).map(|accessor| accessor.0)
            };
            let (Some(joints), Some(weights)) = (attribute("JOINTS"), attribute("WEIGHTS")) else {
                if set == 0 {
                    return Ok(None);
                }
                break;
            };
            let joints = buffers.integers::<4>(joints)?;
            let weights = buffers.fractions::<4>(weights)?;
            if joints.len() != positions.len() || weights.len() != positions.len() {
                return Err(malformed("joints and weights must be one per vertex".to_owned()));
            }
            for ((matrix, sum), (joints, weights)) in
                blended.iter_mut().zip(joints.into_iter().zip(weights))
            {
                for (joint, weight) in joints.into_iter().zip(weights) {
                    // Joints of no weight may be any.
                    if weight == 0.0 {
                        continue;
                    }
                    let Some(joint) = self.0.get(joint as usize) else {
                        return Err(malformed(format!("the skin has no joint {joint}")));
                    };
                    *matrix += *joint * f64::from(weight);
                    *sum += f64::from(weight);
                }
            }
        }
        let first = self.0.first().copied().unwrap_or(DMat4::IDENTITY);
        let place = |(&position, (matrix, sum)): (&[f32; 3], (DMat4, f64))| {
            // Weights add up to 1 but for rounding.
            let matrix = if sum > 0.0 { matrix * (1.0 / sum) } else { first };
            matrix.transform_point3(DVec3::from(position.map(f64::from)))
        };
        Ok(Some(positions.iter().zip(blended).map(place).collect()))
    }
}
