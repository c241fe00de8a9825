//! The vertices of a primitive, with its morph targets by their default weights.

use glam::Vec2;

use super::buffers::Buffers;
use super::json::Primitive;
use super::{at_place, malformed};
use crate::error::Result;

/// The attributes of one primitive, as many as it has vertices.
pub(super) struct Vertices<'a> {
    pub(super) primitive: &'a Primitive,
    pub(super) buffers: &'a Buffers<'a>,
    /// Weight of each morph target; 0 for those beyond.
    pub(super) weights: &'a [f32],
}

impl Vertices<'_> {
    /// The positions; `None` if there are none to draw.
    pub(super) fn positions(&self) -> Result<Option<Vec<[f32; 3]>>> {
        let Some(accessor) = self.accessor("POSITION") else { return Ok(None) };
        let positions = self.buffers.floats::<3>(accessor)?;
        self.morphed("POSITION", positions, |buffers, at| buffers.floats::<3>(at)).map(Some)
    }

    /// The texture coordinates of a set; `None` if there are none.
    pub(super) fn uvs(&self, set: usize, count: usize) -> Result<Option<Vec<Vec2>>> {
        let name = format!("TEXCOORD_{set}");
        let Some(accessor) = self.accessor(&name) else { return Ok(None) };
        let uvs = self.buffers.floats::<2>(accessor)?;
        self.check("texture coordinates", uvs.len(), count)?;
        let uvs = self.morphed(&name, uvs, |buffers, at| buffers.floats::<2>(at))?;
        Ok(Some(uvs.into_iter().map(Vec2::from).collect()))
    }

    /// The alpha of each vertex's colour, in [0, 1]; `None` if all are 1.
    pub(super) fn alphas(&self, count: usize) -> Result<Option<Vec<f32>>> {
        let Some(accessor) = self.accessor("COLOR_0") else { return Ok(None) };
        if self.buffers.width(accessor)? != 4 {
            return Ok(None);
        }
        let colours = self.buffers.fractions::<4>(accessor)?;
        self.check("colours", colours.len(), count)?;
        let colours = self.morphed("COLOR_0", colours, |buffers, at| buffers.fractions::<4>(at))?;
        let alpha = |[_, _, _, alpha]: [f32; 4]| {
            let alpha = alpha.clamp(0.0, 1.0);
            if alpha.is_nan() { 1.0 } else { alpha }
        };
        Ok(Some(colours.into_iter().map(alpha).collect()))
    }

    /// The vertices of the triangles' corners, in the order of the primitive's mode.
    pub(super) fn indices(&self, count: usize) -> Result<Vec<u32>> {
        let Some(accessor) = self.primitive.indices else { return Ok((0..count as u32).collect()) };
        let indices = self.buffers.integers::<1>(accessor.0)?;
        if let Some([corner]) = indices.iter().find(|&&[corner]| corner as usize >= count) {
            let reason = format!("vertex {corner} is out of range: there are {count}");
            return Err(malformed(reason));
        }
        Ok(indices.into_iter().flatten().collect())
    }

    fn accessor(&self, name: &str) -> Option<usize> {
        self.primitive.attributes.get(name).map(|accessor| accessor.0)
    }

    fn check(&self, what: &str, found: usize, count: usize) -> Result<()> {
        if found == count {
            Ok(())
        } else {
            Err(malformed(format!("{what} must be one per vertex")))
        }
    }

    /// Values with what morph targets add to them.
    fn morphed<const N: usize>(
        &self,
        name: &str,
        mut values: Vec<[f32; N]>,
        read: impl Fn(&crate::load::gltf::buffers::Buffers<'_>, usize) -> Result<Vec<[f32; N]>>,
    ) -> Result<Vec<[f32; N]>> {
        for (index, target) in self.primitive.targets.iter().enumerate() {
            let weight = self.weights.get(index).copied().unwrap_or(0.0);
            let Some(accessor) = target.get(name).filter(|_| weight != 0.0) else { continue };
            let place = |error| at_place(error, &format!("morph target {index}"));
            // Before it is read: zeros take no bytes.
            let found = self.buffers.count(accessor.0).map_err(place)?;
            self.check("displacements", found, values.len()).map_err(place)?;
            let displacements = read(self.buffers, accessor.0).map_err(place)?;
            for (value, displacement) in values.iter_mut().zip(displacements) {
                for (part, more) in value.iter_mut().zip(displacement) {
                    *part += weight * more;
                }
            }
        }
        Ok(values)
    }
}
