//! Depth ranges of pixels that come in any order.

use dsm_core::{Error, Result};

use crate::min_max_pyramid::{EMPTY, MinMaxPyramid};

/// Collects what a [`MinMaxPyramid`] is made of, pixel by pixel in any order: of a
/// map that is read tile by tile.
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
    size: [u32; 2],
    ranges: Vec<[f32; 2]>,
}

impl MinMaxBuilder {
    /// A map of `size` pixels, all of them empty.
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
        Ok(Self { size, ranges: vec![EMPTY; count as usize] })
    }

    /// States the least and the greatest w of a pixel's layers. A range that is not
    /// in order counts as none.
    ///
    /// # Panics
    ///
    /// If the pixel lies outside the map.
    pub fn set(&mut self, [x, y]: [u32; 2], range: [f32; 2]) {
        let range = if range[0] <= range[1] { range } else { EMPTY };
        self.ranges[y as usize * self.size[0] as usize + x as usize] = range;
    }

    /// States the smallest and the largest depth of a pixel's layers, which reach
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
        MinMaxPyramid::over(self.size, self.ranges)
    }
}
