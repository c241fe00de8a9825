//! Construction of a [`MinMaxPyramid`] from pixels in any order.

use dsm_core::Error;
use dsm_core::detail::Result;

use crate::min_max_pyramid::MinMaxPyramid;
use crate::range_blocks::{EMPTY, RangeBlocks};

/// A builder of a [`MinMaxPyramid`], pixel by pixel in any order, as a map is read
/// tile by tile.
///
/// ```
/// use dsm_trace::detail::MinMaxBuilder;
///
/// let mut builder = MinMaxBuilder::new([2, 1])?;
/// builder.set_depths([1, 0], [2.0, 4.0], 0.0);
/// let pyramid = builder.finish();
/// assert!(pyramid.node(0, 0, 0).is_none());
/// assert!(pyramid.range().is_some_and(|[low, high]| low <= 0.25 && high >= 0.5));
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct MinMaxBuilder {
    ranges: RangeBlocks,
}

impl MinMaxBuilder {
    /// A builder for a map of `size` pixels, all of them empty.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] above [`MinMaxPyramid::MAX_PIXELS`].
    pub fn new(size: [u32; 2]) -> Result<Self> {
        let count = u64::from(size[0]) * u64::from(size[1]);
        let limit = MinMaxPyramid::MAX_PIXELS;
        if count > limit {
            return Err(Error::TooLarge { what: "pixels of a pyramid", count, limit });
        }
        Ok(Self { ranges: RangeBlocks::new(size) })
    }

    /// Sets the minimum and maximum w of a pixel's layers. A range that is not in
    /// order counts as none.
    ///
    /// # Panics
    ///
    /// If the pixel lies outside the map.
    pub fn set(&mut self, pixel: [u32; 2], range: [f32; 2]) {
        self.ranges.set(pixel, if range[0] <= range[1] { range } else { EMPTY });
    }

    /// Sets the minimum and maximum depth of a pixel's layers, which reach
    /// `threshold` further to either side. Rounded outwards.
    ///
    /// # Panics
    ///
    /// If the pixel lies outside the map.
    pub fn set_depths(&mut self, pixel: [u32; 2], depths: [f32; 2], threshold: f64) {
        let [near, far] = depths.map(f64::from);
        // No nearer than the camera's plane.
        let near = (near - threshold).max(f64::from(f32::MIN_POSITIVE));
        let [low, high] = [far + threshold, near].map(|z| z.recip() as f32);
        self.set(pixel, [low.next_down().max(0.0), high.next_up().min(f32::MAX)]);
    }

    /// The pyramid. O(pixels).
    #[must_use]
    pub fn finish(self) -> MinMaxPyramid {
        MinMaxPyramid::over(self.ranges)
    }
}

impl MinMaxPyramid {
    /// The pyramid of a map of `size` pixels, from depths: `range` gives the
    /// minimum and maximum depth of a pixel's layers, which reach `threshold`
    /// further to either side. Rounded outwards. O(pixels).
    ///
    /// # Errors
    ///
    /// As [`Self::new`].
    pub fn of_depths(
        size: [u32; 2],
        threshold: f64,
        range: impl Fn(usize) -> Option<[f32; 2]>,
    ) -> Result<Self> {
        let mut builder = MinMaxBuilder::new(size)?;
        for (x, y) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))) {
            if let Some(depths) = range(y as usize * size[0] as usize + x as usize) {
                builder.set_depths([x, y], depths, threshold);
            }
        }
        Ok(builder.finish())
    }

    /// The pyramid of a map of `size` pixels: `range` gives the minimum and maximum
    /// w of a pixel's layers, or `None` where there are none. Ranges that are not
    /// in order count as none. O(pixels).
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] above [`Self::MAX_PIXELS`].
    pub fn new(
        size: [u32; 2],
        mut range: impl FnMut(u32, u32) -> Option<[f32; 2]>,
    ) -> Result<Self> {
        let mut builder = MinMaxBuilder::new(size)?;
        for (x, y) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))) {
            if let Some(range) = range(x, y) {
                builder.set([x, y], range);
            }
        }
        Ok(builder.finish())
    }
}
