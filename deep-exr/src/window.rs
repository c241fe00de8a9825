//! Rectangles of pixels.

/// Windows may not reach further (OpenEXR's own bound: sizes then fit i32).
pub(crate) const FARTHEST_PIXEL: i32 = i32::MAX / 2;

/// A rectangle of pixels: both corners belong to it.
///
/// ```
/// use deep_exr::Window;
///
/// assert_eq!(Window { min: [-3, 2], max: [4, 2] }.size(), [8, 1]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// The upper left pixel.
    pub min: [i32; 2],
    /// The lower right pixel.
    pub max: [i32; 2],
}

impl Window {
    /// Width and height in pixels; 0 where `max` lies before `min`.
    #[must_use]
    pub fn size(self) -> [u64; 2] {
        [0, 1].map(|axis| {
            let [first, last] = [self.min[axis], self.max[axis]].map(i64::from);
            (last + 1 - first).max(0).unsigned_abs()
        })
    }

    /// True if it has pixels and lies within the 2³⁰ pixels around the origin that
    /// OpenEXR allows.
    #[must_use]
    pub fn is_valid(self) -> bool {
        let near = |n: &i32| n.unsigned_abs() < FARTHEST_PIXEL.unsigned_abs();
        !self.size().contains(&0) && self.min.iter().chain(&self.max).all(near)
    }
}
