//! The cone that holds a group of rays.

/// Rays from one point of a raster: all with slopes between two, for u in
/// [near, far], the gain of w since that point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cone {
    pub(crate) place: [f32; 2],
    pub(crate) w: f32,
    /// Least and greatest slope of either axis, in pixels per unit of w.
    pub(crate) slopes: [[f32; 2]; 2],
    pub(crate) near: f32,
    pub(crate) far: f32,
}

impl Cone {
    /// No ray yet.
    pub(crate) const fn empty(place: [f32; 2], w: f32) -> Self {
        let none = [f32::INFINITY, f32::NEG_INFINITY];
        Self { place, w, slopes: [none; 2], near: f32::INFINITY, far: f32::NEG_INFINITY }
    }

    /// Holds the rays of `other` from the same place, too.
    #[inline(always)]
    pub(crate) fn include(&mut self, other: &Self) {
        for (axis, slopes) in self.slopes.iter_mut().enumerate() {
            slopes[0] = slopes[0].min(other.slopes[axis][0]);
            slopes[1] = slopes[1].max(other.slopes[axis][1]);
        }
        self.near = self.near.min(other.near);
        self.far = self.far.max(other.far);
    }

    /// Whether there is nothing in it.
    pub(crate) fn is_empty(&self) -> bool {
        self.near.is_nan() || self.near > self.far
    }

    /// Steps in u at least this small move no ray by more than the slack.
    pub(crate) fn slack(&self) -> f32 {
        2e-6 * (self.w.abs() + self.far.abs())
    }

    /// Slopes below move no ray by more than a millionth of a pixel, whatever the unit
    /// of depths.
    pub(crate) fn least_slope(&self) -> f32 {
        (1e-6 / (self.w.abs() + self.far.abs())).max(f32::MIN_POSITIVE)
    }
}
