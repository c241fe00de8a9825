//! The vertices of a visibility function, for algorithms that walk along it.

use super::function::{VisibilityFunction, VisibilityView};
use super::vertex::Vertex;
use crate::transmittance::Transmittance;

/// A piecewise linear function of depth, 1 before its first vertex and
/// constant behind its last: a stored [`VisibilityView`], the vertices of one
/// that is not compressed yet, or a [`TransmittanceFunction`]. Depths don't
/// decrease, and at most two vertices share one.
///
/// [`TransmittanceFunction`]: crate::curve::transmittance_function::TransmittanceFunction
pub trait Polyline {
    /// One `f64` a channel: [`Transmittance::Sum`].
    type Sum: Copy + AsRef<[f64]> + AsMut<[f64]>;

    /// Number of vertices.
    fn vertex_count(&self) -> usize;

    /// Vertex `index`, which is below [`Self::vertex_count`].
    fn sum_vertex(&self, index: usize) -> Vertex<Self::Sum>;

    /// True if the function is anything but a staircase: pairs of vertices, each
    /// pair a step, flat in between. O(n) unless it is known.
    fn has_ramps(&self) -> bool {
        let count = self.vertex_count();
        let is_step = |near: usize| {
            let [before, after] = [near, near + 1].map(|vertex| self.sum_vertex(vertex));
            let is_flat = |value: &[f64]| before.value.as_ref() == value;
            before.z == after.z
                && match near.checked_sub(1) {
                    Some(previous) => is_flat(self.sum_vertex(previous).value.as_ref()),
                    None => before.value.as_ref().iter().all(|&value| value == 1.0),
                }
        };
        !(count.is_multiple_of(2) && (0..count).step_by(2).all(is_step))
    }
}

impl<P: Polyline + ?Sized> Polyline for &P {
    type Sum = P::Sum;

    fn vertex_count(&self) -> usize {
        (**self).vertex_count()
    }

    fn sum_vertex(&self, index: usize) -> Vertex<P::Sum> {
        (**self).sum_vertex(index)
    }

    fn has_ramps(&self) -> bool {
        (**self).has_ramps()
    }
}

impl<T: Transmittance> Polyline for VisibilityView<'_, T> {
    type Sum = T::Sum;

    fn vertex_count(&self) -> usize {
        self.len()
    }

    fn sum_vertex(&self, index: usize) -> Vertex<T::Sum> {
        Vertex::new(self.depths()[index], self.value(index).to_sum())
    }
}

impl<T: Transmittance> Polyline for VisibilityFunction<T> {
    type Sum = T::Sum;

    fn vertex_count(&self) -> usize {
        self.view().len()
    }

    fn sum_vertex(&self, index: usize) -> Vertex<T::Sum> {
        self.view().sum_vertex(index)
    }
}

impl<S: Copy + AsRef<[f64]> + AsMut<[f64]>> Polyline for [Vertex<S>] {
    type Sum = S;

    fn vertex_count(&self) -> usize {
        self.len()
    }

    fn sum_vertex(&self, index: usize) -> Vertex<S> {
        self[index]
    }
}

impl<S: Copy + AsRef<[f64]> + AsMut<[f64]>> Polyline for Vec<Vertex<S>> {
    type Sum = S;

    fn vertex_count(&self) -> usize {
        self.len()
    }

    fn sum_vertex(&self, index: usize) -> Vertex<S> {
        self[index]
    }
}
