//! A control point of a piecewise linear function of depth.

use crate::transmittance::Transmittance;

/// A control point (z, value) of a piecewise linear function of depth. Two
/// successive vertices at one z are a step.
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
