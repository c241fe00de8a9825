//! Rays.

use glam::DVec3;

/// A ray: the points `origin` + t · `direction` for t in [near, far), at a time of
/// the shutter. t is a distance or a depth, depending on the direction's length.
///
/// ```
/// use dsm_core::Ray;
/// use glam::DVec3;
///
/// let ray = Ray::between(DVec3::ZERO, DVec3::new(0.0, 0.0, 4.0)).at_time(0.5);
/// assert_eq!(ray.at(0.25), DVec3::Z);
/// assert_eq!(ray.range(), [0.0, 1.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    origin: DVec3,
    direction: DVec3,
    near: f64,
    far: f64,
    time: f64,
}

impl Ray {
    /// The half line from `origin` on, when the shutter opens. A ray whose numbers
    /// are not finite, or without a direction, hits nothing.
    #[must_use]
    pub const fn new(origin: DVec3, direction: DVec3) -> Self {
        Self { origin, direction, near: 0.0, far: f64::INFINITY, time: 0.0 }
    }

    /// The segment between two points: t is 0 at the first and 1 at the second.
    #[must_use]
    pub fn between(from: DVec3, to: DVec3) -> Self {
        Self::new(from, to - from).within(0.0, 1.0)
    }

    /// Keeps the ray's points for t in [`near`, `far`) only; `near` below 0 counts as 0.
    #[must_use]
    pub const fn within(self, near: f64, far: f64) -> Self {
        Self { near: near.max(0.0), far, ..self }
    }

    /// Sets the `time` of the ray, from 0 where the shutter opens to 1.
    #[must_use]
    pub const fn at_time(self, time: f64) -> Self {
        Self { time, ..self }
    }

    /// The point at t = 0.
    #[must_use]
    pub const fn origin(&self) -> DVec3 {
        self.origin
    }

    /// The displacement per unit of t.
    #[must_use]
    pub const fn direction(&self) -> DVec3 {
        self.direction
    }

    /// The first and the last t.
    #[must_use]
    pub const fn range(&self) -> [f64; 2] {
        [self.near, self.far]
    }

    /// The time of the shutter.
    #[must_use]
    pub const fn time(&self) -> f64 {
        self.time
    }

    /// The point at `t`.
    #[must_use]
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }

    /// True if the ray can hit anything.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        self.origin.is_finite()
            && self.direction.is_finite()
            && self.direction != DVec3::ZERO
            && self.near < self.far
            && self.near.is_finite()
    }
}
