//! Reconstruction filters: the weights of samples around a pixel's centre, and of
//! pixels around a lookup (Lokovic & Veach 2000, §3.1 and §3.4). None has negative
//! lobes, so that visibility stays monotone.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

/// The shape of a filter, on [−1, 1].
///
/// ```
/// use dsm_core::FilterShape;
///
/// assert_eq!(FilterShape::Tent.weight(0.25), 0.75);
/// assert_eq!(FilterShape::Box.weight(1.5), 0.0);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FilterShape {
    /// Constant.
    #[default]
    Box,
    /// 1 − |t|.
    Tent,
    /// exp(−2 t²), cut off at |t| = 1.
    Gaussian,
}

impl FilterShape {
    /// The shape's name, as the command line spells it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Box => "box",
            Self::Tent => "tent",
            Self::Gaussian => "gaussian",
        }
    }

    /// The narrowest full width, in pixels, that always reaches a pixel's
    /// centre.
    #[must_use]
    pub const fn minimum_width(self) -> f32 {
        match self {
            Self::Box | Self::Gaussian => 1.0,
            Self::Tent => 2.0,
        }
    }

    /// The weight at `t`, in [0, 1]; 0 outside [−1, 1]. The interval is
    /// half-open, (−1, 1], so that abutting boxes share no sample.
    #[must_use]
    pub fn weight(self, t: f64) -> f64 {
        if t > -1.0 && t <= 1.0 { self.profile(t) } else { 0.0 }
    }

    /// The weight at `t`, which lies in [−1, 1].
    #[inline(always)]
    pub(crate) fn profile(self, t: f64) -> f64 {
        match self {
            Self::Box => 1.0,
            Self::Tent => (1.0 - t.abs()).max(0.0),
            Self::Gaussian => (-2.0 * t * t).exp(),
        }
    }
}

/// A separable filter with a full width of support in pixels.
///
/// ```
/// use dsm_core::{Filter, FilterShape};
///
/// let tent = Filter::new(FilterShape::Tent, 4.0)?;
/// assert_eq!(tent.weight(1.0, 0.0), 0.5);
/// assert_eq!(tent.weight(2.5, 0.0), 0.0);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Filter {
    shape: FilterShape,
    width: f32,
}

impl Filter {
    /// A filter of `width` pixels.
    ///
    /// # Errors
    ///
    /// [`Error::FilterWidth`] if the width is not finite or below
    /// [`FilterShape::minimum_width`].
    pub fn new(shape: FilterShape, width: f32) -> Result<Self> {
        let minimum = shape.minimum_width();
        if width >= minimum && width < f32::INFINITY {
            Ok(Self { shape, width })
        } else {
            Err(Error::FilterWidth { shape: shape.name(), width, minimum })
        }
    }

    /// The filter's shape.
    #[must_use]
    pub const fn shape(self) -> FilterShape {
        self.shape
    }

    /// The full width of the filter's support, in pixels.
    #[must_use]
    pub const fn width(self) -> f32 {
        self.width
    }

    /// This filter where a pixel's side is `scale` times as many pixels, at least
    /// as wide as its shape must be.
    #[inline(always)]
    pub(crate) fn scaled(self, scale: f32) -> Self {
        let width = (self.width * scale).max(self.shape.minimum_width());
        Self { width, ..self }
    }

    /// The weight along one axis at `offset` pixels from the centre.
    #[must_use]
    pub fn weight_along(self, offset: f64) -> f64 {
        self.shape.weight(offset / (0.5 * f64::from(self.width)))
    }

    /// The weight at (`dx`, `dy`) pixels from the centre; not normalised.
    #[must_use]
    pub fn weight(self, dx: f64, dy: f64) -> f64 {
        self.weight_along(dx) * self.weight_along(dy)
    }

    /// The weights of sample points at these offsets from the pixel's centre,
    /// in pixels, normalised to a sum of 1. All zero if the filter reaches no
    /// sample.
    #[must_use]
    pub fn normalized_weights(self, offsets: &[(f64, f64)]) -> Vec<f64> {
        let mut weights: Vec<f64> = offsets.iter().map(|&(dx, dy)| self.weight(dx, dy)).collect();
        normalize(&mut weights);
        weights
    }

    /// Number of pixels beyond a pixel that the filter reaches.
    pub(crate) fn border(self) -> f64 {
        (0.5 * f64::from(self.width) - 0.5).ceil()
    }

    /// True if the filter covers its pixel evenly and nothing beyond.
    #[must_use]
    pub fn is_pixel(self) -> bool {
        self.shape == FilterShape::Box && self.width == 1.0
    }

    /// The number of evenly weighted pixels that would leave as much noise as the
    /// filter does: 1/Σ w² for one sample a pixel. 1 for a box of one pixel.
    #[must_use]
    pub fn effective_pixels(self) -> f64 {
        // (∫f)² / ∫f² over [−1, 1]: of pixels half as wide as the filter.
        let along = match self.shape {
            FilterShape::Box => 2.0,
            FilterShape::Tent => 1.5,
            FilterShape::Gaussian => 1.196_288_013_322_608_f64.powi(2) / 0.882_081_390_762_421_7,
        };
        (along * 0.5 * f64::from(self.width)).powi(2)
    }
}

/// Scales weights to a sum of 1; leaves zeros alone.
pub(crate) fn normalize(weights: &mut [f64]) {
    let sum: f64 = weights.iter().sum();
    if sum > 0.0 {
        weights.iter_mut().for_each(|weight| *weight /= sum);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPES: [FilterShape; 3] = [FilterShape::Box, FilterShape::Tent, FilterShape::Gaussian];

    #[test]
    fn vanishes_outside_its_support_and_is_never_negative() {
        for shape in SHAPES {
            let filter = Filter::new(shape, 3.0).unwrap();
            for step in -400..=400 {
                let offset = f64::from(step) * 0.01;
                let weight = filter.weight_along(offset);
                assert!((0.0..=1.0).contains(&weight));
                assert!(offset.abs() <= 1.5 || weight == 0.0, "{shape:?} at {offset}");
            }
            assert_eq!(filter.weight_along(0.0), 1.0);
        }
    }

    #[test]
    fn integrals_match_their_closed_forms() {
        // ∫ over [-1, 1] of exp(-2 t²) = sqrt(π/2) erf(√2).
        for (shape, integral) in SHAPES.into_iter().zip([2.0, 1.0, 1.196_288_013_322_608]) {
            let steps = 200_000;
            let sum: f64 = (0..steps)
                .map(|step| shape.weight((f64::from(step) + 0.5) * 2.0 / f64::from(steps) - 1.0))
                .sum();
            assert!((sum * 2.0 / f64::from(steps) - integral).abs() < 1e-9, "{shape:?}");
        }
    }

    #[test]
    fn weights_sum_to_one() {
        let offsets = [(0.1, -0.3), (0.4, 0.4), (-0.2, 0.9), (7.0, 0.0)];
        for shape in SHAPES {
            let weights = Filter::new(shape, 2.0).unwrap().normalized_weights(&offsets);
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-15);
            assert_eq!(weights[3], 0.0);
        }
    }

    #[test]
    fn effective_pixels_are_those_of_dense_samples() {
        for (shape, width) in SHAPES.into_iter().flat_map(|shape| [(shape, 2.0), (shape, 5.0)]) {
            let filter = Filter::new(shape, width).unwrap();
            let per_pixel = 64;
            let along: Vec<f64> = (-3 * per_pixel..3 * per_pixel)
                .map(|step| filter.weight_along((f64::from(step) + 0.5) / f64::from(per_pixel)))
                .collect();
            let sum: f64 = along.iter().sum();
            let squares: f64 = along.iter().map(|weight| (weight / sum).powi(2)).sum();
            let pixels = (squares * f64::from(per_pixel)).powi(-2);
            assert!((filter.effective_pixels() / pixels - 1.0).abs() < 1e-3, "{filter:?}");
        }
        assert_eq!(Filter::new(FilterShape::Box, 1.0).unwrap().effective_pixels(), 1.0);
    }

    #[test]
    fn borders_hold_all_that_the_filter_reaches() {
        for (width, border) in [(1.0, 0.0), (1.01, 1.0), (2.0, 1.0), (3.0, 1.0), (3.5, 2.0)] {
            assert_eq!(Filter::new(FilterShape::Box, width).unwrap().border(), border);
        }
    }

    #[test]
    fn too_narrow_a_filter_is_refused() {
        assert!(Filter::new(FilterShape::Tent, 1.5).is_err());
        assert!(Filter::new(FilterShape::Box, 0.5).is_err());
        assert!(Filter::new(FilterShape::Box, f32::NAN).is_err());
        assert!(Filter::new(FilterShape::Gaussian, f32::INFINITY).is_err());
    }

    #[test]
    fn abutting_boxes_share_no_sample() {
        let filter = Filter::new(FilterShape::Box, 1.0).unwrap();
        assert_eq!(filter.weight_along(0.5) + filter.weight_along(-0.5), 1.0);
    }
}
