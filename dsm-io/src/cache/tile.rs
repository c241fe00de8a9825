//! A tile in the cache.

use std::sync::Arc;

use dsm_core::Transmittance;
use dsm_core::detail::{PixelLists, PixelListsView};

use super::statistics::Counters;
use crate::map_tile::MapTile;

/// A tile's pixels, held in memory by whoever has it: of a deep map
/// [`PixelLists`], of another kind its [`MapKind::Tile`](crate::kind::map_kind::MapKind::Tile).
#[derive(Debug)]
pub struct CachedTile<P> {
    pixels: P,
    bytes: u64,
    counters: Arc<Counters>,
}

/// A tile that somebody holds; none if it is empty.
pub(super) type Held<P> = Option<Arc<CachedTile<P>>>;

impl<P: MapTile> CachedTile<P> {
    pub(super) fn new(pixels: P, counters: &Arc<Counters>) -> Self {
        let bytes = pixels.bytes();
        counters.tile_made(bytes);
        Self { pixels, bytes, counters: Arc::clone(counters) }
    }
}

impl<P> CachedTile<P> {
    /// The tile's pixels.
    #[must_use]
    #[inline(always)]
    pub const fn pixels(&self) -> &P {
        &self.pixels
    }

    /// Bytes of the tile's columns and pixel tables, which is what the budget
    /// counts.
    #[must_use]
    pub const fn bytes(&self) -> u64 {
        self.bytes
    }
}

impl<T: Transmittance> CachedTile<PixelLists<T>> {
    /// The pixels of a deep map's tile.
    #[must_use]
    #[inline(always)]
    pub fn view(&self) -> PixelListsView<'_, T> {
        self.pixels.view()
    }
}

impl<P> Drop for CachedTile<P> {
    fn drop(&mut self) {
        self.counters.tile_dropped(self.bytes);
    }
}
