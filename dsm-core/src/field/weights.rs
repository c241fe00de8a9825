//! Weights of the pixels around a receiver.

use fearless_simd::{Simd, SimdBase, f64x8};

use super::footprint::Ellipse;
use crate::filter::{Filter, FilterShape};

/// Neighbours in a row whose weights are computed at once.
pub(super) const STRIP: usize = 8;

/// The weights of the pixels around a receiver, by their offsets from it.
pub(super) trait PixelWeights {
    /// Half extents of the box outside of which no pixel has a weight; its
    /// intervals are half-open.
    fn reach(&self) -> [f64; 2];

    /// The offsets in x between which the pixels of the row at `dy` can have
    /// a weight; `None` if it is all that the box holds.
    fn chord(&self, dy: f64) -> Option<[f64; 2]>;

    /// The factor that all weights of the row at `dy` share.
    fn row(&self, row: u32, dy: f64) -> f64;

    /// The rest of a pixel's weight.
    fn pixel(&self, column: u32, offset: [f64; 2]) -> f64;

    /// The same for `count` pixels from `column` on, the first of which is at
    /// `offset`, and more that mean nothing.
    #[inline(always)]
    fn strip<S: Simd>(&self, _: S, column: u32, count: usize, [x, dy]: [f64; 2]) -> [f64; STRIP] {
        let mut weights = [0.0; STRIP];
        for (weight, column) in weights[..count].iter_mut().zip(column..) {
            *weight = self.pixel(column, [f64::from(column) + 0.5 - x, dy]);
        }
        weights
    }
}

/// The part of a level that lies in the map, in pixels of the level.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent(pub(super) [f64; 2]);

impl Extent {
    /// The share of a pixel's side that lies in the map, for an axis and an
    /// index along it: only the last of a line can lie partly outside.
    #[inline(always)]
    fn cover(self, axis: usize, pixel: u32) -> f64 {
        (self.0[axis] - f64::from(pixel)).min(1.0)
    }
}

/// A separable filter.
pub(super) struct Separable {
    filter: Filter,
    /// Takes offsets to [−1, 1].
    scale: f64,
    reach: f64,
    extent: Extent,
}

impl Separable {
    #[inline(always)]
    pub(super) fn new(filter: Filter, extent: Extent) -> Self {
        let width = f64::from(filter.width());
        Self { filter, scale: 2.0 / width, reach: 0.5 * width, extent }
    }
}

impl PixelWeights for Separable {
    #[inline(always)]
    fn reach(&self) -> [f64; 2] {
        [self.reach; 2]
    }

    #[inline(always)]
    fn chord(&self, _: f64) -> Option<[f64; 2]> {
        None
    }

    #[inline(always)]
    fn row(&self, row: u32, dy: f64) -> f64 {
        self.extent.cover(1, row) * self.filter.shape().profile(dy * self.scale)
    }

    #[inline(always)]
    fn pixel(&self, column: u32, [dx, _]: [f64; 2]) -> f64 {
        self.extent.cover(0, column) * self.filter.shape().profile(dx * self.scale)
    }

    /// The operations of [`Self::pixel`], 8 at a time.
    #[inline(always)]
    fn strip<S: Simd>(&self, simd: S, column: u32, count: usize, [x, _]: [f64; 2]) -> [f64; STRIP] {
        let real = |value: f64| f64x8::splat(simd, value);
        let ahead = f64x8::load_array(simd, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        let columns = real(f64::from(column)) + ahead;
        let cover = (real(self.extent.0[0]) - columns).min(real(1.0));
        let at = (columns + real(0.5) - real(x)) * real(self.scale);
        match self.filter.shape() {
            FilterShape::Box => cover.to_array(),
            FilterShape::Tent => (cover * (real(1.0) - at.abs()).max(real(0.0))).to_array(),
            shape @ FilterShape::Gaussian => {
                let (mut weights, at) = (cover.to_array(), at.to_array());
                for (weight, at) in weights[..count].iter_mut().zip(at) {
                    *weight *= shape.profile(at);
                }
                weights
            }
        }
    }
}

/// An ellipse.
pub(super) struct Radial {
    pub(super) ellipse: Ellipse,
    pub(super) extent: Extent,
}

impl PixelWeights for Radial {
    #[inline(always)]
    fn reach(&self) -> [f64; 2] {
        self.ellipse.reach()
    }

    #[inline(always)]
    fn chord(&self, dy: f64) -> Option<[f64; 2]> {
        Some(self.ellipse.chord(dy))
    }

    #[inline(always)]
    fn row(&self, row: u32, _: f64) -> f64 {
        self.extent.cover(1, row)
    }

    #[inline(always)]
    fn pixel(&self, column: u32, [dx, dy]: [f64; 2]) -> f64 {
        self.extent.cover(0, column) * self.ellipse.weight(dx, dy)
    }
}
