//! What a visibility function is while it is walked along: its vertices.

use crate::{Transmittance, Vertex, VisibilityFunction, VisibilityView};

/// A piecewise linear function of depth, 1 before its first vertex and
/// constant behind its last: a stored [`VisibilityView`] or the vertices of
/// one that is not compressed yet. Depths don't decrease.
pub trait Polyline {
    /// One `f64` a channel: [`Transmittance::Sum`].
    type Sum: Copy + AsRef<[f64]> + AsMut<[f64]>;

    /// Number of vertices.
    fn vertex_count(&self) -> usize;

    /// Vertex `index`, which is below [`Self::vertex_count`].
    fn sum_vertex(&self, index: usize) -> Vertex<Self::Sum>;
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
