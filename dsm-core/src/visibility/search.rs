//! Search in the depths of one pixel, the inner loop of lookups.
//!
//! A binary search ends where nobody can foresee, and each of its loads waits
//! for the one before. So all vertices of a usual pixel are compared at once
//! and counted, and nothing waits but for the pixel's start. Comparisons and
//! counts are exact: every processor finds the same vertices.

use std::hint::select_unpredictable;
use std::ops::Range;

use fearless_simd::{Simd, SimdBase, SimdMask, f32x16};

/// Vertices that are compared at once, in two vectors.
const WIDTH: usize = 32;

/// 32 neighbours in a column, among which are the vertices around a depth.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Window {
    start: usize,
    /// The first one that belongs to the pixel, and how many do.
    first: u32,
    count: u32,
}

impl Window {
    /// The window around `z` among these vertices of a column of depths, which
    /// are a pixel's, ascending, and at least one. `None` if the column is
    /// shorter than a window. O(log n), and no step for up to 32 vertices.
    #[inline(always)]
    pub(crate) fn around(depths: &[f32], vertices: Range<usize>, z: f32) -> Option<Self> {
        let last = depths.len().checked_sub(WIDTH)?;
        let (mut first, mut count) = (vertices.start, vertices.len());
        // The vertices on both sides of z stay among those that are left.
        while count > WIDTH {
            let half = (count - 1) / 2;
            first = select_unpredictable(depths[first + half] <= z, first + half, first);
            count -= half;
        }
        let start = first.min(last);
        Some(Self { start, first: (first - start) as u32, count: count as u32 })
    }

    /// The index of its first vertex in the column.
    #[inline(always)]
    pub(crate) const fn start(self) -> usize {
        self.start
    }

    /// The window in another column of the same vertices.
    #[inline(always)]
    pub(crate) fn of(self, column: &[f32]) -> Option<&[f32; WIDTH]> {
        column.get(self.start..)?.first_chunk()
    }

    /// The pixel's last vertex at a depth ≤ `z` and its next, counted from the
    /// window's start. In front of the first and past the last vertex it is
    /// that one twice. O(1).
    #[inline(always)]
    pub(crate) fn bracket<S: Simd>(self, simd: S, depths: &[f32; WIDTH], z: f32) -> [usize; 2] {
        let z = f32x16::splat(simd, z);
        let (near, far) = depths.split_at(WIDTH / 2);
        let near = f32x16::from_slice(simd, near).simd_le(z).to_bitmask() & 0xffff;
        let far = f32x16::from_slice(simd, far).simd_le(z).to_bitmask() & 0xffff;
        // Neighbours' vertices don't count.
        let own = ((1_u64 << self.count) - 1) << self.first;
        let next = self.first + ((near | far << 16) & own).count_ones();
        let near = next.max(self.first + 1) - 1;
        let far = next.min(self.first + self.count - 1);
        // Both are below the width: this spares the checks.
        [near as usize % WIDTH, far as usize % WIDTH]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};

    /// Pixels of 1 to 150 vertices on a grid where many are at one depth, asked
    /// at, between and beyond them, in columns that end with the pixel or don't.
    #[test]
    fn windows_hold_what_a_binary_search_finds() {
        for count in 1..150_usize {
            for (before, after) in [(0, 0), (0, 40), (7, 0), (3, 1), (40, 40)] {
                let mut depths = vec![9.0; before];
                depths.extend((0..count).map(|index| (index * 7 / 9) as f32 * 0.5));
                depths.extend(vec![0.0; after]);
                let pixel = before..before + count;
                for step in -1..=4 * count as i32 {
                    let z = step as f32 * 0.25;
                    let Some(window) = Window::around(&depths, pixel.clone(), z) else {
                        assert!(depths.len() < WIDTH);
                        continue;
                    };
                    let next = depths[pixel.clone()].partition_point(|&depth| depth <= z);
                    let expected = [next.saturating_sub(1), next.min(count - 1)];
                    let column = window.of(&depths).unwrap();
                    for level in [Level::new(), Level::baseline()] {
                        let found = dispatch!(level, simd => window.bracket(simd, column, z));
                        let found = found.map(|lane| window.start() + lane - before);
                        assert_eq!(found, expected, "{z} among {count} after {before}");
                    }
                }
            }
        }
    }
}
