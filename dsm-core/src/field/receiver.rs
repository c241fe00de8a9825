//! Receivers of shadow in raster space.

use super::weights::Extent;

/// A receiver: a raster position and a depth at which visibility is queried.
///
/// ```
/// use dsm_core::Receiver;
///
/// let receiver = Receiver { bias: 0.01, ..Receiver::new([10.5, 4.25], 3.0) };
/// assert_eq!(receiver.depth_gradient, [0.0; 2]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receiver {
    /// Raster position: pixel (i, j) covers [i, i+1) × [j, j+1).
    pub position: [f32; 2],
    /// Depth, in scene units.
    pub depth: f32,
    /// The depth bias, in scene units: subtracted from the depth (§4 on bias).
    pub bias: f32,
    /// The gradient of the receiver's depth per pixel in x and y: each pixel is
    /// queried at the depth of the receiver's plane there. Zero queries all pixels
    /// at one depth.
    pub depth_gradient: [f32; 2],
}

impl Receiver {
    /// A receiver without bias that faces the light.
    #[must_use]
    pub const fn new(position: [f32; 2], depth: f32) -> Self {
        Self { position, depth, bias: 0.0, depth_gradient: [0.0; 2] }
    }

    /// True if the receiver lies in a field of this size and behind the light, with
    /// no NaN: else it is lit.
    #[inline(always)]
    pub(super) fn is_shaded_by(&self, Extent([width, height]): Extent) -> bool {
        let [x, y] = self.position;
        let (x, y) = (f64::from(x), f64::from(y));
        x >= 0.0 && y >= 0.0 && x < width && y < height && self.depth > 0.0
    }

    /// This receiver where a pixel's side is `scale`, a power of two, times as many
    /// pixels.
    #[inline(always)]
    pub(super) fn scaled(self, scale: f32) -> Self {
        let ([x, y], [dx, dy]) = (self.position, self.depth_gradient);
        Self { position: [x * scale, y * scale], depth_gradient: [dx / scale, dy / scale], ..self }
    }

    /// The distance of the centre of the pixel with this index along `axis` from
    /// the receiver.
    #[inline(always)]
    pub(super) fn offset(&self, axis: usize, pixel: u32) -> f64 {
        f64::from(pixel) + 0.5 - f64::from(self.position[axis])
    }

    /// The depth at which all pixels are queried, if that is one and they are
    /// not lit for it.
    #[inline(always)]
    pub(super) fn common_depth(&self) -> Option<f32> {
        if self.depth_gradient == [0.0; 2] { self.depth_at([0.0; 2]) } else { None }
    }

    /// The depth of the receiver's plane at an offset, less the bias; `None`
    /// where it is lit for its depth.
    #[inline(always)]
    pub(super) fn depth_at(&self, offset: [f64; 2]) -> Option<f32> {
        let plane = f64::from(self.depth)
            + f64::from(self.depth_gradient[0]) * offset[0]
            + f64::from(self.depth_gradient[1]) * offset[1];
        let depth = (plane - f64::from(self.bias)) as f32;
        (depth > 0.0).then_some(depth)
    }
}
