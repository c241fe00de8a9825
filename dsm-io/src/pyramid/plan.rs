//! The plan of a pyramid: its parts, and the error that each may add.

use dsm_core::detail::MipPyramid;
use dsm_core::{Compression, MapInfo, Tolerance};

use crate::error::{Error, Result};

/// Levels of a pyramid, and the error bound of each.
///
/// ```
/// use dsm_io::PyramidOptions;
///
/// let options = PyramidOptions::default().with_levels(4).with_tolerance_scale(1.0);
/// assert_eq!((options.levels, options.tolerance_scale), (4, 1.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PyramidOptions {
    /// The maximum number of levels, level 0 included. Default: all, down
    /// to 1 × 1.
    pub levels: u32,
    /// The factor from the tolerance of a level to that of the next; see
    /// [`Tolerance::of_level`]. In (0, 1], by default ½.
    pub tolerance_scale: f32,
}

impl Default for PyramidOptions {
    fn default() -> Self {
        Self { levels: u32::MAX, tolerance_scale: 0.5 }
    }
}

impl PyramidOptions {
    /// Sets the maximum number of levels, level 0 included.
    #[must_use]
    pub const fn with_levels(self, levels: u32) -> Self {
        Self { levels, ..self }
    }

    /// Sets the factor of tolerances from level to level.
    #[must_use]
    pub const fn with_tolerance_scale(self, scale: f32) -> Self {
        Self { tolerance_scale: scale, ..self }
    }
}

/// A pyramid, its tiles and tolerances.
///
/// A *cell* is a square of level-0 pixels whose side is the largest power of
/// two that divides a tile's: a tile is a square of whole cells, and a pixel of
/// level `cell_level` is one of them. A *node* of height h is a square of 2ʰ
/// by 2ʰ tiles, so that level h's tile with the same position covers the same
/// part of the map.
#[derive(Debug)]
pub(super) struct Plan {
    pub(super) pyramid: MipPyramid,
    pub(super) tile_size: u32,
    /// The coarsest level whose pixels never cross the border of a tile.
    pub(super) cell_level: u32,
    /// Cells a tile has in a row: width of a node's block of pixels of level
    /// `cell_level` + its height.
    pub(super) block_size: u32,
    /// The compressor of every level.
    pub(super) compression: Compression,
    tolerance: Tolerance,
    scale: f32,
}

impl Plan {
    pub(super) fn new(
        [width, height]: [u32; 2],
        tile_size: u32,
        info: &MapInfo,
        options: &PyramidOptions,
    ) -> Result<Self> {
        let tolerance = info.tolerance;
        let compression = Compression::of_stated(info.compression);
        let scale = options.tolerance_scale;
        if !(0.0 < scale && scale <= 1.0) {
            let reason = format!("a tolerance scale must lie in (0, 1], not {scale}");
            return Err(Error::setting(reason));
        }
        if options.levels == 0 {
            return Err(Error::setting("a map has at least one level"));
        }
        let pyramid = MipPyramid::new(width, height).finest(options.levels);
        let cell_level = tile_size.trailing_zeros().min(pyramid.level_count() - 1);
        let block_size = tile_size >> cell_level;
        Ok(Self { pyramid, tile_size, cell_level, block_size, compression, tolerance, scale })
    }

    /// The coarsest level.
    pub(super) fn top(&self) -> u32 {
        self.pyramid.level_count() - 1
    }

    /// The tolerance that a level states.
    pub(super) fn tolerance(&self, level: u32) -> Tolerance {
        self.tolerance.of_level(level, self.scale)
    }

    /// What a copy of a pixel of `level` may be off, if coarser levels are
    /// averages of such copies: an eighth of the tolerance of any of them, or
    /// less where more than four levels follow each other so. All copies on
    /// the way to a level together take at most half of its tolerance.
    pub(super) fn copy_tolerance(&self, level: u32) -> Option<Tolerance> {
        if !(self.cell_level..self.top()).contains(&level) {
            return None;
        }
        // Tolerances never rise from level 1 on.
        let least = f64::from(self.tolerance(self.top()).epsilon());
        let share = f64::from(8.max(2 * (self.top() - self.cell_level)));
        Some(self.tolerance(self.top()).after(least - least / share))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(size: [u32; 2], tile_size: u32, epsilon: f32) -> Plan {
        let tolerance = Tolerance::new(epsilon).unwrap();
        {
            let info = MapInfo::new().with_tolerance(tolerance);
            Plan::new(size, tile_size, &info, &PyramidOptions::default())
        }
        .unwrap()
    }

    #[test]
    fn cells_are_as_large_as_tiles_allow() {
        for (tile_size, cell_level, block_size) in
            [(64, 6, 1), (48, 4, 3), (7, 0, 7), (1, 0, 1), (1 << 12, 9, 8)]
        {
            let plan = plan([500, 3], tile_size, 0.02);
            assert_eq!(plan.top(), 9);
            assert_eq!((plan.cell_level, plan.block_size), (cell_level, block_size), "{tile_size}");
        }
    }

    #[test]
    fn copies_take_at_most_half_of_any_tolerance() {
        for (size, tile_size, epsilon) in
            [(16_384, 64, 0.02), (i32::MAX as u32, 1, 0.9), (65, 64, 0.0), (512, 64, 0.2)]
        {
            let plan = plan([size, 1], tile_size, epsilon);
            let mut copies = 0.0;
            for level in 1..=plan.top() {
                copies += plan.copy_tolerance(level - 1).map_or(0.0, |copy| copy.epsilon().into());
                let stated = f64::from(plan.tolerance(level).epsilon());
                assert!(copies <= 0.5 * stated, "level {level} of {size}: {copies}");
                assert_eq!(copies > 0.0, level > plan.cell_level);
            }
            assert_eq!(plan.copy_tolerance(plan.top()), None);
        }
    }

    #[test]
    fn senseless_options_are_refused() {
        let build = |options| Plan::new([9, 9], 4, &MapInfo::new(), &options);
        assert!(build(PyramidOptions::default().with_levels(0)).is_err());
        for scale in [0.0, -1.0, 1.1, f32::NAN] {
            assert!(build(PyramidOptions::default().with_tolerance_scale(scale)).is_err());
        }
        assert_eq!(build(PyramidOptions::default().with_levels(2)).unwrap().top(), 1);
    }
}
