//! Geometry and tolerances of a mip pyramid (Lokovic & Veach 2000, §5.3).

use std::ops::Range;

use crate::tolerance::Tolerance;

/// The levels of a map: level 0 is the map, each other half as wide and high
/// as the one before, rounded up, down to 1 × 1.
///
/// Pixel (x, y) of level k stands for the pixels of level 0 in columns x·2ᵏ to
/// (x + 1)·2ᵏ − 1 and rows likewise, as far as the map reaches: its function
/// is their average, each of one weight. Where the last column or row reaches
/// beyond the map, the four pixels of the level before weigh the area of the
/// map that they cover, so that no pixel of the map counts more than another.
///
/// ```
/// use dsm_core::detail::MipPyramid;
///
/// let pyramid = MipPyramid::new(5, 2);
/// let sizes: Vec<_> = (0..pyramid.level_count()).map(|level| pyramid.size(level)).collect();
/// assert_eq!(sizes, [[5, 2], [3, 1], [2, 1], [1, 1]]);
/// // The second pixel of level 2 covers one column of the map, the first four.
/// let parts: Vec<_> = pyramid.children(3, [0, 0]).collect();
/// assert_eq!(parts, [([0, 0], 0.8), ([1, 0], 0.2)]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MipPyramid {
    width: u32,
    height: u32,
    levels: u32,
}

impl MipPyramid {
    /// All levels of a map of `width` × `height` pixels, at least 1 each.
    #[must_use]
    pub const fn new(width: u32, height: u32) -> Self {
        let longer = if width > height { width } else { height };
        let halvings = u32::BITS - longer.saturating_sub(1).leading_zeros();
        Self { width, height, levels: 1 + halvings }
    }

    /// The finest `levels` of these, at least one.
    #[must_use]
    pub fn finest(self, levels: u32) -> Self {
        Self { levels: self.levels.min(levels.max(1)), ..self }
    }

    /// Number of levels, with level 0: 1 to 33.
    #[must_use]
    pub const fn level_count(self) -> u32 {
        self.levels
    }

    /// Width and height of a level, in its pixels.
    #[must_use]
    pub fn size(self, level: u32) -> [u32; 2] {
        // At most as much as that of level 0.
        [self.width, self.height].map(|side| u64::from(side).div_ceil(1 << level) as u32)
    }

    /// The columns and rows of level 0 that a pixel covers.
    #[must_use]
    pub fn covered(self, level: u32, pixel: [u32; 2]) -> [Range<u32>; 2] {
        let side = |index: u32, end: u32| {
            let start = u64::from(index) << level;
            let end = u64::from(end);
            // Both are at most `end`.
            start.min(end) as u32..(start + (1 << level)).min(end) as u32
        };
        [side(pixel[0], self.width), side(pixel[1], self.height)]
    }

    /// Number of level-0 pixels that a pixel covers: 0 outside the level.
    #[must_use]
    pub fn area(self, level: u32, pixel: [u32; 2]) -> u64 {
        let [columns, rows] = self.covered(level, pixel);
        columns.len() as u64 * rows.len() as u64
    }

    /// The pixels of the level before that a pixel of level `level` ≥ 1
    /// averages, row by row, with their weights, which sum to 1 but for
    /// rounding: one, two or four.
    pub fn children(self, level: u32, [x, y]: [u32; 2]) -> impl Iterator<Item = ([u32; 2], f64)> {
        let whole = self.area(level, [x, y]).max(1) as f64;
        let finer = level.saturating_sub(1);
        [(0, 0), (1, 0), (0, 1), (1, 1)].into_iter().filter_map(move |(right, down)| {
            let child =
                [x.checked_mul(2)?.checked_add(right)?, y.checked_mul(2)?.checked_add(down)?];
            let area = self.area(finer, child);
            (area > 0).then_some((child, area as f64 / whole))
        })
    }
}

impl Tolerance {
    /// The smallest tolerance that a level above level 0 is held to.
    pub const MIP_FLOOR: f32 = 1e-4;

    /// The tolerance of mip level `level` of a map with this one:
    /// ε · scaleˡᵉᵛᵉˡ, but at least [`Self::MIP_FLOOR`], for level 0 ε itself.
    ///
    /// A coarse pixel averages more samples and has less noise to hide an
    /// error in, so that `scale` is ½ in the paper (§5.3). The floor holds for
    /// an ε of 0 as well: an exact average of 4ᵏ functions has the vertices of
    /// all of them, and every level would be as large as the map.
    ///
    /// ```
    /// use dsm_core::Tolerance;
    ///
    /// let tolerance = Tolerance::new(0.02)?;
    /// assert_eq!(tolerance.of_level(2, 0.5), Tolerance::new(0.005)?);
    /// assert_eq!(tolerance.of_level(20, 0.5).epsilon(), Tolerance::MIP_FLOOR);
    /// assert_eq!(Tolerance::EXACT.of_level(1, 0.5).epsilon(), Tolerance::MIP_FLOOR);
    /// # Ok::<(), dsm_core::Error>(())
    /// ```
    #[must_use]
    pub fn of_level(self, level: u32, scale: f32) -> Self {
        if level == 0 {
            return self;
        }
        let scaled = f64::from(self.epsilon()) * f64::from(scale).powi(level as i32);
        // A scale above 1 must not leave [0, 1); NaN gives the floor.
        let scaled = (scaled as f32).max(Self::MIP_FLOOR).min(1.0_f32.next_down());
        Self::new(scaled).unwrap_or(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_halve_down_to_one_pixel() {
        let sizes = |width, height| {
            let pyramid = MipPyramid::new(width, height);
            (0..pyramid.level_count()).map(|level| pyramid.size(level)).collect::<Vec<_>>()
        };
        assert_eq!(sizes(1, 1), [[1, 1]]);
        assert_eq!(sizes(8, 4), [[8, 4], [4, 2], [2, 1], [1, 1]]);
        assert_eq!(sizes(1, 5), [[1, 5], [1, 3], [1, 2], [1, 1]]);
        assert_eq!(sizes(9, 1), [[9, 1], [5, 1], [3, 1], [2, 1], [1, 1]]);
        assert_eq!(sizes(u32::MAX, 1).len(), 33);
        assert_eq!(MipPyramid::new(9, 1).finest(3).level_count(), 3);
        assert_eq!(MipPyramid::new(9, 1).finest(0).level_count(), 1);
        assert_eq!(MipPyramid::new(9, 1).finest(40).level_count(), 5);
    }

    #[test]
    fn every_pixel_of_the_map_counts_once_in_every_level() {
        for (width, height) in [(1, 1), (5, 3), (7, 1), (16, 9), (13, 13)] {
            let pyramid = MipPyramid::new(width, height);
            for level in 0..pyramid.level_count() {
                let [columns, rows] = pyramid.size(level);
                let pixels = (0..rows).flat_map(|y| (0..columns).map(move |x| [x, y]));
                let mut area = 0;
                for pixel in pixels {
                    let own = pyramid.area(level, pixel);
                    assert!(own > 0);
                    area += own;
                    if level > 0 {
                        let children: Vec<_> = pyramid.children(level, pixel).collect();
                        let inside = |&([x, y], _): &([u32; 2], f64)| {
                            let [width, height] = pyramid.size(level - 1);
                            x < width && y < height
                        };
                        assert!(children.iter().all(inside), "{children:?}");
                        let sum: u64 =
                            children.iter().map(|&(child, _)| pyramid.area(level - 1, child)).sum();
                        assert_eq!(sum, own);
                        let weights: f64 = children.iter().map(|&(_, weight)| weight).sum();
                        assert!((weights - 1.0).abs() < 1e-15);
                    }
                }
                assert_eq!(area, u64::from(width) * u64::from(height));
            }
        }
    }

    #[test]
    fn tolerances_halve_down_to_the_floor() {
        let tolerance = Tolerance::new(0.25).unwrap();
        let levels: Vec<_> = (0..4).map(|level| tolerance.of_level(level, 0.5).epsilon()).collect();
        assert_eq!(levels, [0.25, 0.125, 0.0625, 0.03125]);
        assert_eq!(tolerance.of_level(9, 1.0), tolerance);
        assert_eq!(tolerance.of_level(9, 3.0).epsilon(), 1.0_f32.next_down());
        let small = Tolerance::new(1e-5).unwrap();
        assert_eq!(small.of_level(0, 0.5), small);
        for scale in [0.5, 0.0, f32::NAN] {
            assert_eq!(small.of_level(1, scale).epsilon(), Tolerance::MIP_FLOOR);
        }
    }
}
