//! What shadow rays meet.

use glam::DVec3;

/// What a shadow ray met on its way to the light.
///
/// ```
/// use dsm_core::detail::Occlusion;
/// use glam::DVec3;
///
/// let leaf = Occlusion { transmittance: 0.0_f32, blocker: Some(DVec3::Y) };
/// assert_ne!(leaf, Occlusion { transmittance: 1.0, blocker: None });
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Occlusion<T> {
    /// The share of the light that is left, of one channel or three.
    pub transmittance: T,
    /// A point of the ray, in the world, where an occluder takes light, if the
    /// tracer knows one.
    pub blocker: Option<DVec3>,
}
