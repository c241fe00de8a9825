//! The mean transmittance over an area light.

use dsm_core::Transmittance;

/// The mean of the transmittances of a light's shadow rays, one `f64` a channel
/// while it is summed: the shadow factor that every method estimates.
///
/// ```
/// use dsm_core::AreaLight;
/// use dsm_trace::detail::LightMean;
/// use glam::DVec3;
///
/// // A screen that covers the half of the light with x < 0.
/// let light = AreaLight::rectangle(DVec3::Y, DVec3::X, DVec3::Z);
/// let mut mean = LightMean::<f32>::new();
/// for point in light.samples(DVec3::ZERO, 64, 1) {
///     mean.add(if point.x < 0.0 { 0.0 } else { 1.0 });
/// }
/// assert_eq!(mean.of(64), 0.5);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct LightMean<T: Transmittance> {
    sum: T::Sum,
}

impl<T: Transmittance> LightMean<T> {
    /// The mean of no rays so far.
    #[must_use]
    pub fn new() -> Self {
        Self { sum: T::BLOCKED.to_sum() }
    }

    /// Adds the transmittance of one ray.
    #[inline]
    pub fn add(&mut self, transmittance: T) {
        self.add_sum(transmittance.to_sum());
    }

    /// Adds a transmittance, or a sum of several, as it was computed.
    #[inline]
    pub fn add_sum(&mut self, left: T::Sum) {
        for (sum, left) in self.sum.as_mut().iter_mut().zip(left.as_ref()) {
            *sum += left;
        }
    }

    /// The mean over `rays` rays, at least 1.
    #[inline]
    #[must_use]
    pub fn of(mut self, rays: u32) -> T {
        self.sum.as_mut().iter_mut().for_each(|sum| *sum /= f64::from(rays));
        T::from_sum(self.sum)
    }
}

impl<T: Transmittance> Default for LightMean<T> {
    fn default() -> Self {
        Self::new()
    }
}
