//! The levels of a prefiltered map: MIP-map, then stack (Selgrad et al. 2014, §4.2,
//! figure 7).

use dsm_core::Error;
use dsm_core::detail::Result;

/// Where the texels of a level stand, and how wide its filter is. Places and widths
/// are in texels of level 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelGeometry {
    /// Width and height in texels of the level.
    pub size: [u32; 2],
    /// Column and row of the first texel, in texels of the level: below 0 where a stack
    /// reaches out of the map.
    pub origin: [i32; 2],
    /// Distance of texels.
    pub spacing: u32,
    /// Side of the box that a texel is the mean over.
    pub width: u32,
    /// That the texels of a stack stand on corners of those of the last MIP level.
    pub is_stack: bool,
    /// Texels of level 0 along the box's side that were looked at.
    pub samples: u32,
}

impl LevelGeometry {
    /// A place of level 0 in texels of the level, from the centre of the first: whole
    /// numbers are centres.
    #[must_use]
    #[inline]
    pub fn texel(&self, place: [f64; 2]) -> [f64; 2] {
        let half = if self.is_stack { 0.0 } else { 0.5 };
        let spacing = f64::from(self.spacing);
        [0, 1].map(|axis| place[axis] / spacing - half - f64::from(self.origin[axis]))
    }

    /// The centre of a texel, in texels of level 0.
    #[must_use]
    #[inline]
    pub fn centre(&self, texel: [f64; 2]) -> [f64; 2] {
        let half = if self.is_stack { 0.0 } else { 0.5 };
        let spacing = f64::from(self.spacing);
        [0, 1].map(|axis| (texel[axis] + half + f64::from(self.origin[axis])) * spacing)
    }

    /// The side of the box of the variance that a lookup between four texels has:
    /// the level's own samples, and the tent of the interpolation.
    #[must_use]
    pub fn filter_size(&self) -> f64 {
        let (samples, spacing) = (f64::from(self.samples), f64::from(self.spacing));
        // n samples along a width have the variance (1 − 1/n²) / 12 of it, a tent over
        // two spacings that of 1/6.
        let own = f64::from(self.width).powi(2) * (1.0 - samples.powi(-2));
        (own + 2.0 * spacing.powi(2)).sqrt()
    }
}

/// Which levels there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct LevelPlan {
    /// The last MIP level: what follows is a stack.
    pub(super) stack_from: Option<u32>,
    /// The last level.
    pub(super) last: u32,
    /// Levels up to this one take one list of four.
    pub(super) subsampled: u32,
}

impl LevelPlan {
    /// Level 0 alone.
    pub(super) const BASE: Self = Self { stack_from: None, last: 0, subsampled: 0 };

    /// The last level that a map of this size can have: its filter covers all of it.
    pub(super) fn coarsest(size: [u32; 2]) -> u32 {
        size[0].max(size[1]).max(1).next_power_of_two().ilog2()
    }

    /// The levels of a map of `size` texels, the finest first.
    ///
    /// # Errors
    ///
    /// [`Error::Level`] for more levels than the map can have.
    pub(super) fn geometry(&self, size: [u32; 2]) -> Result<Vec<LevelGeometry>> {
        let refuse = |reason| Err(Error::Level { level: self.last as usize, reason });
        if self.last > Self::coarsest(size) {
            return refuse("its filter is wider than the map");
        }
        if size.iter().any(|&side| side == 0 || side > 1 << 24) {
            return refuse("a map has 1 to 2²⁴ texels a side");
        }
        let levels = (0..=self.last).map(|level| {
            let mip = self.stack_from.map_or(level, |last| level.min(last));
            let stage = size.map(|side| side.div_ceil(1 << mip));
            let samples = 1 << (level - level.min(self.subsampled));
            let (spacing, width) = (1 << mip, 1 << level);
            if level == mip {
                let (origin, is_stack) = ([0; 2], false);
                return LevelGeometry { size: stage, origin, spacing, width, is_stack, samples };
            }
            // All texels whose filter reaches the map; of the last, those that lookups in
            // the map read.
            let reach = 1_u32 << (level - mip - 1);
            let pad = if level == self.last { 0 } else { reach - 1 };
            let size = stage.map(|side| side + 1 + 2 * pad);
            let origin = [-(pad as i32); 2];
            LevelGeometry { size, origin, spacing, width, is_stack: true, samples }
        });
        Ok(levels.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mip_map_halves_and_a_stack_does_not() {
        let plan = LevelPlan { stack_from: None, last: 4, subsampled: 0 };
        let levels = plan.geometry([13, 9]).unwrap();
        let sizes: Vec<_> = levels.iter().map(|level| level.size).collect();
        assert_eq!(sizes, [[13, 9], [7, 5], [4, 3], [2, 2], [1, 1]]);
        assert_eq!(levels[2].texel([6.0, 2.0]), [1.0, 0.0]);
        let plan = LevelPlan { stack_from: Some(1), ..plan };
        let levels = plan.geometry([13, 9]).unwrap();
        let sizes: Vec<_> = levels.iter().map(|level| level.size).collect();
        assert_eq!(sizes, [[13, 9], [7, 5], [8, 6], [10, 8], [8, 6]]);
        assert_eq!(levels[3].origin, [-1, -1]);
        for level in &levels {
            let at = level.texel([5.25, 3.5]);
            assert_eq!(level.centre(at), [5.25, 3.5]);
        }
        assert!(LevelPlan { last: 5, ..plan }.geometry([13, 9]).is_err());
    }

    #[test]
    fn filter_sizes_are_those_of_their_variance() {
        let plan = LevelPlan { stack_from: Some(2), last: 5, subsampled: 0 };
        for level in plan.geometry([64, 64]).unwrap() {
            // Of samples at the middles of n cells, and of a tent.
            let (n, cell) = (level.samples, f64::from(level.width) / f64::from(level.samples));
            let offsets = (0..n).map(|k| (f64::from(k) + 0.5 - f64::from(n) / 2.0) * cell);
            let own = offsets.map(|x| x * x).sum::<f64>() / f64::from(n);
            let tent = f64::from(level.spacing).powi(2) / 6.0;
            assert!((level.filter_size().powi(2) / 12.0 - own - tent).abs() < 1e-9, "{level:?}");
        }
    }
}
