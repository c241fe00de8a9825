//! A tile in the cache.

use std::hint::black_box;
use std::ops::Range;
use std::sync::Arc;

use dsm_core::{PixelLists, PixelListsView, Transmittance};

use super::statistics::Counters;
use crate::tile::Tile;

/// Vertices of the rows that are touched: more would fill the nearest cache,
/// and rows that long are streams which the processor sees by itself.
const MOST_TOUCHED: usize = 1 << 14;

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

    /// Asks memory for all that lookups read of these rows, which lie within
    /// the tile: a word of every cache line, none waiting for another, so that
    /// they come together and not one after the other. O(vertices / 16).
    pub(super) fn touch(&self, rows: Range<u32>) {
        let view = self.view();
        let width = view.width() as usize;
        let pixels = rows.start as usize * width..rows.end as usize * width;
        let of = |starts: &[u32]| starts[pixels.start] as usize..starts[pixels.end] as usize;
        let depths = of(view.starts());
        if depths.len() <= MOST_TOUCHED {
            touch(&view.starts()[pixels.clone()], |&start| start);
            touch(&view.depths()[depths.clone()], |depth| depth.to_bits());
            let values = if T::CHANNELS == 1 {
                depths
            } else {
                touch(&view.value_starts()[pixels.clone()], |&start| start);
                of(view.value_starts())
            };
            touch(&view.values()[values], |value| value.to_bits());
        }
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

/// Reads a word of every cache line.
#[inline(always)]
fn touch<V>(column: &[V], bits: impl Fn(&V) -> u32) {
    let words = column.iter().step_by(16).chain(column.last());
    black_box(words.fold(0, |sum, word| sum ^ bits(word)));
}
