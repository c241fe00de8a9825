//! A tile in the cache.

use std::sync::Arc;

use dsm_core::{PixelLists, PixelListsView, Transmittance};

use super::statistics::Counters;
use crate::Tile;

/// A tile's pixels, held in memory by whoever has it.
#[derive(Debug)]
pub struct CachedTile<T> {
    pixels: PixelLists<T>,
    bytes: u64,
    counters: Arc<Counters>,
}

impl<T: Transmittance> CachedTile<T> {
    /// A copy of a tile that lies in its file, or the one that was decoded.
    pub(super) fn new(tile: Tile<'_, T>, counters: &Arc<Counters>) -> Self {
        let pixels = match tile {
            Tile::Borrowed(pixels) => pixels.to_lists(),
            Tile::Owned(pixels) => pixels,
        };
        let view = pixels.view();
        let table = view.starts().len() + view.value_starts().len();
        let columns = view.depths().len() + view.values().len();
        let bytes = 4 * (table + columns) as u64;
        counters.tile_made(bytes);
        Self { pixels, bytes, counters: Arc::clone(counters) }
    }

    /// The tile's pixels.
    #[must_use]
    #[inline(always)]
    pub fn view(&self) -> PixelListsView<'_, T> {
        self.pixels.view()
    }

    /// Bytes of the tile's columns and pixel tables, which is what the budget
    /// counts.
    #[must_use]
    pub const fn bytes(&self) -> u64 {
        self.bytes
    }
}

impl<T> Drop for CachedTile<T> {
    fn drop(&mut self) {
        self.counters.tile_dropped(self.bytes);
    }
}
