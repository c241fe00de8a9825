//! The rows of a held tile that lookups are about to read.
//!
//! A tile's rows are short: whenever lookups in scan order cross into another
//! tile, the processor has to find out anew which lines of memory come next,
//! in every column of every row, and each of those is waited for. So the first
//! lookup of a row in a tile asks for the whole row.

use std::cell::Cell;
use std::ops::Range;

use dsm_core::Transmittance;

use crate::kind::map_kind::FieldKind;

/// How far a lookup went from the one before, in pixels, modulo 2³².
#[derive(Clone, Copy, Debug)]
pub(super) struct Step([u32; 2]);

impl Step {
    /// Neighbours read the rest of a row soon; others may never.
    const NEAR: u32 = 8;

    #[inline(always)]
    pub(super) fn between(before: [u32; 2], now: [u32; 2]) -> Self {
        Self([now[0].wrapping_sub(before[0]), now[1].wrapping_sub(before[1])])
    }

    fn is_near(self) -> bool {
        self.0.iter().all(|by| by.wrapping_add(Self::NEAR) <= 2 * Self::NEAR)
    }
}

/// The rows of a tile that were touched last, in pixels of the level.
#[derive(Debug, Default)]
pub(super) struct RowsAhead(Cell<[u32; 2]>);

impl RowsAhead {
    /// More rows than this were touched too long ago to be in a cache still.
    const MOST: u32 = 16;

    /// Another tile takes the place.
    pub(super) fn forget(&self) {
        self.0.set([0; 2]);
    }

    /// Touches those of `rows` that were not, if a neighbour was looked up
    /// before. They lie within the tile, whose first row is `top`.
    #[inline(always)]
    pub(super) fn include<K: FieldKind, T: Transmittance>(
        &self,
        rows: &Range<u32>,
        step: Step,
        top: u32,
        tile: Option<&K::Tile<T>>,
    ) {
        let [start, end] = self.0.get();
        if rows.start < start || rows.end > end {
            self.touch::<K, T>([rows.start, rows.end], step, top, tile);
        }
    }

    #[cold]
    #[inline(never)]
    fn touch<K: FieldKind, T: Transmittance>(
        &self,
        rows: [u32; 2],
        step: Step,
        top: u32,
        tile: Option<&K::Tile<T>>,
    ) {
        let (Some(tile), true) = (tile, step.is_near()) else { return };
        let touched = self.0.get();
        let [start, end] = [touched[0].min(rows[0]), touched[1].max(rows[1])];
        let is_apart = rows[0] > touched[1] || rows[1] < touched[0];
        if is_apart || end - start > Self::MOST {
            self.0.set(rows);
            K::prefetch(tile, rows[0] - top..rows[1] - top);
        } else {
            self.0.set([start, end]);
            // One of both is empty, unless the block grew.
            K::prefetch(tile, start - top..touched[0] - top);
            K::prefetch(tile, touched[1] - top..end - top);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kind::deep::Deep;
    use dsm_core::detail::PixelLists;
    use dsm_core::{PixelListsBuilder, Rgb, Vertex};

    const NEAR: Step = Step([3, 0_u32.wrapping_sub(8)]);
    const FAR: Step = Step([0, 9]);

    /// Rows 100 to 164 of a level: 0 to 4 vertices a pixel.
    fn tile<T: Transmittance>() -> PixelLists<T> {
        let mut pixels = PixelListsBuilder::new(3, 64);
        for pixel in 0..3 * 64 {
            for vertex in 0..pixel % 5 {
                pixels.push(Vertex::new(1.0 + vertex as f32, T::CLEAR));
            }
            pixels.finish_pixel().unwrap();
        }
        pixels.finish().unwrap()
    }

    fn rows_are_touched<T: Transmittance>() {
        let (tile, ahead) = (tile::<T>(), RowsAhead::default());
        for (rows, step, touched) in [
            (100..103, FAR, [0, 0]),
            (100..103, NEAR, [100, 103]),
            (101..102, NEAR, [100, 103]),
            (102..109, FAR, [100, 103]),
            (102..109, NEAR, [100, 109]),
            // Too many together, then apart, on both sides.
            (109..117, NEAR, [109, 117]),
            (161..164, NEAR, [161, 164]),
            (152..156, NEAR, [152, 156]),
            (150..152, NEAR, [150, 156]),
            (149..157, NEAR, [149, 157]),
        ] {
            ahead.include::<Deep, T>(&rows, step, 100, Some(&tile));
            assert_eq!(ahead.0.get(), touched, "{rows:?}");
        }
        ahead.forget();
        ahead.include::<Deep, T>(&(100..164), NEAR, 100, None);
        assert_eq!(ahead.0.get(), [0, 0]);
    }

    #[test]
    fn rows_are_touched_once_by_neighbours() {
        rows_are_touched::<f32>();
        rows_are_touched::<Rgb>();
    }
}
