//! A control point of a piecewise linear function of depth.

use crate::transmittance::Transmittance;

/// A control point (z, value) of a piecewise linear function of depth. Two
/// successive vertices at one z are a step.
///
/// ```
/// use dsm_core::{Vertex, VisibilityFunction};
///
/// // A step from 1 to 0.5 at depth 2, then a ramp to 0 at depth 4.
/// let vertices = [(2.0, 1.0), (2.0, 0.5), (4.0, 0.0)].map(|(z, value)| Vertex::new(z, value));
/// let function = VisibilityFunction::<f32>::new(vertices)?;
/// assert_eq!(function.view().at(3.0), 0.25);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex<V> {
    /// Depth along the view axis, in scene units, finite and ≥ 0.
    pub z: f32,
    /// The function's value there: a [`Transmittance`] where it is stored, its
    /// `Sum` (`f64` a channel) while it is computed.
    pub value: V,
}

impl<V> Vertex<V> {
    /// A vertex at depth `z`.
    pub const fn new(z: f32, value: V) -> Self {
        Self { z, value }
    }
}

/// A vertex while it is computed: one `f64` a channel.
pub type SumVertex<T> = Vertex<<T as Transmittance>::Sum>;
