//! Hits of one cell.

use dsm_core::detail::Result;
use dsm_core::{TileHits, TileSamples, Transmittance};
use glam::DVec2;

use super::cells::LANES;
use super::primitive::Primitive;
use super::rays::Rays;

/// The hits of a cell in columns, in the order of the primitives. Keeps its memory
/// from cell to cell.
#[derive(Clone, Debug, Default)]
pub(super) struct CellHits {
    /// Hits must lie behind this depth.
    pub(super) near: f32,
    pub(super) samples: Vec<u32>,
    pub(super) depths: Vec<f32>,
    pub(super) count: usize,
    /// True if `items` is kept.
    pub(super) keeps_items: bool,
    /// Each primitive that was met, and the count after it.
    pub(super) items: Vec<(u32, usize)>,
}

impl CellHits {
    /// Forgets the hits and makes room for `vectors` vectors of them.
    #[inline(always)]
    pub(super) fn reset(&mut self, vectors: usize) {
        self.count = 0;
        self.items.clear();
        let room = (vectors + 1) * LANES;
        if self.samples.len() < room {
            self.samples.resize(room, 0);
            self.depths.resize(room, 0.0);
        }
    }

    /// Adds the hits to `hits`.
    #[inline]
    pub(super) fn push<T: Transmittance>(&self, opacity: T, hits: &mut TileHits<T>) -> Result<()> {
        hits.push_surfaces(&self.samples[..self.count], &self.depths[..self.count], opacity)
    }

    /// Adds the hits to `hits`, each with the normal of its primitive.
    pub(super) fn push_with_normals<T: Transmittance, P: Primitive>(
        &self,
        opacity: T,
        primitives: &[P],
        rays: &Rays,
        samples: &TileSamples,
        hits: &mut TileHits<T>,
    ) -> Result<()> {
        let mut start = 0;
        for &(item, end) in &self.items {
            let primitive = &primitives[item as usize];
            // What moves has a normal for each time, what turns one for each ray.
            let step = if P::MOVES || P::TURNS { 1 } else { end - start };
            while start < end {
                let run = start..start + step;
                let (found, depths) = (&self.samples[run.clone()], &self.depths[run]);
                let first = found[0] as usize;
                let raster = DVec2::new(samples.x()[first], samples.y()[first]);
                let ray = rays.slope(rays.through(raster)).extend(-1.0);
                match primitive.normal(rays, samples.times()[first], ray) {
                    Some(normal) => {
                        hits.push_surfaces_with_normal(found, depths, opacity, normal)?;
                    }
                    None => hits.push_surfaces(found, depths, opacity)?,
                }
                start += step;
            }
        }
        Ok(())
    }
}
