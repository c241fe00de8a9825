//! The hits of one cell.

use dsm_core::{Result, TileHits, Transmittance};

use super::cells::LANES;

/// Hits in columns, as they are found. Keeps its memory from cell to cell.
#[derive(Clone, Debug, Default)]
pub(super) struct Found {
    /// Hits must lie behind this depth.
    pub(super) near: f32,
    pub(super) samples: Vec<u32>,
    pub(super) depths: Vec<f32>,
    pub(super) count: usize,
}

impl Found {
    /// Forgets the hits and makes room for `vectors` vectors of them.
    #[inline(always)]
    pub(super) fn reset(&mut self, vectors: usize) {
        self.count = 0;
        let room = (vectors + 1) * LANES;
        if self.samples.len() < room {
            self.samples.resize(room, 0);
            self.depths.resize(room, 0.0);
        }
    }

    /// Hands over the hits.
    #[inline]
    pub(super) fn push<T: Transmittance>(&self, opacity: T, hits: &mut TileHits<T>) -> Result<()> {
        hits.push_surfaces(&self.samples[..self.count], &self.depths[..self.count], opacity)
    }
}
