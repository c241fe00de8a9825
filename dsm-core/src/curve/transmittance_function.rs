//! Transmittance along one ray (Lokovic & Veach 2000, §3.2).

use crate::transmittance::Transmittance;
use crate::visibility::polyline::Polyline;
use crate::visibility::vertex::{SumVertex, Vertex};

/// A transmittance function: τ(z), the fraction of light that passes everything at
/// depth ≤ z on one ray; the product of the transmittances of surfaces and media
/// (Lokovic & Veach 2000, §3.2).
///
/// Piecewise linear. Vertices are sorted by depth, at most two at one depth (a
/// step); their values are 1 at the first vertex, in \[0, 1\] and
/// non-increasing in every channel. 1 before the first vertex, right-continuous
/// at steps; the last value holds to infinity. No vertices: 1 everywhere. Steps
/// are exact, and so is every vertex up to `f64` rounding; between the
/// vertices of a medium the chord misses the exponential by a chosen error at
/// most (see [`TransmittanceBuilder`](super::transmittance_builder::TransmittanceBuilder)).
///
/// ```
/// use dsm_core::{RayHits, SurfaceHit, VolumeSample};
/// use dsm_core::detail::TransmittanceFunction;
///
/// let mut hits = RayHits::<f32>::default();
/// hits.push_surface(SurfaceHit { depth: 3.0, opacity: 0.25 })?;
/// let slab = [1.0, 2.0].map(|depth| VolumeSample { depth, extinction: 0.7 });
/// hits.push_volume(&slab, 1.0)?;
///
/// let function = TransmittanceFunction::new(&hits, 1e-4);
/// assert!((function.before(3.0)[0] - (-0.7_f64).exp()).abs() < 1e-8);
/// assert!((function.at(3.0)[0] - 0.75 * (-0.7_f64).exp()).abs() < 1e-8);
/// assert!(function.is_curved());
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct TransmittanceFunction<T: Transmittance> {
    pub(super) vertices: Vec<SumVertex<T>>,
    pub(super) curved: bool,
}

impl<T: Transmittance> Default for TransmittanceFunction<T> {
    /// The function that is 1 everywhere.
    fn default() -> Self {
        Self { vertices: Vec::new(), curved: false }
    }
}

impl<T: Transmittance> TransmittanceFunction<T> {
    /// The vertices, front to back.
    #[must_use]
    pub fn vertices(&self) -> &[SumVertex<T>] {
        &self.vertices
    }

    /// True if chords stand for exponentials somewhere, so that the chord error was
    /// spent. Otherwise the function is a staircase, and exact.
    #[must_use]
    pub const fn is_curved(&self) -> bool {
        self.curved
    }

    /// τ(∞): the transmittance of everything on the ray.
    #[must_use]
    pub fn last(&self) -> T::Sum {
        self.vertices.last().map_or(T::CLEAR.to_sum(), |vertex| vertex.value)
    }

    /// τ(z): the transmittance of everything at depth ≤ z. 1 for NaN. O(log n).
    #[must_use]
    pub fn at(&self, z: f32) -> T::Sum {
        self.interpolate(self.vertices.partition_point(|vertex| vertex.z <= z), z)
    }

    /// The limit of τ from the light's side: the transmittance of everything in
    /// front of depth z. 1 for NaN. O(log n).
    #[must_use]
    pub fn before(&self, z: f32) -> T::Sum {
        self.interpolate(self.vertices.partition_point(|vertex| vertex.z < z), z)
    }

    /// The value at `z`, between vertices `next - 1` and `next`.
    fn interpolate(&self, next: usize, z: f32) -> T::Sum {
        let Some(near) = next.checked_sub(1).map(|index| self.vertices[index]) else {
            return T::CLEAR.to_sum();
        };
        let Some(far) = self.vertices.get(next) else {
            return near.value;
        };
        if far.z == z {
            return far.value;
        }
        let (z0, z1) = (f64::from(near.z), f64::from(far.z));
        let share = (f64::from(z) - z0) / (z1 - z0);
        T::sum_from_channels(|channel| {
            let (from, to) = (near.value.as_ref()[channel], far.value.as_ref()[channel]);
            from + (to - from) * share
        })
    }
}

impl<T: Transmittance> Polyline for TransmittanceFunction<T> {
    type Sum = T::Sum;

    fn vertex_count(&self) -> usize {
        self.vertices().len()
    }

    fn sum_vertex(&self, index: usize) -> Vertex<T::Sum> {
        self.vertices()[index]
    }

    fn has_ramps(&self) -> bool {
        self.is_curved()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hits::hit::{RayHits, SurfaceHit, VolumeSample};
    use crate::transmittance::Rgb;
    use crate::visibility::vertex::Vertex;

    fn surfaces(hits: &[(f32, f32)]) -> RayHits<f32> {
        let mut ray = RayHits::default();
        for &(depth, opacity) in hits {
            ray.push_surface(SurfaceHit { depth, opacity }).unwrap();
        }
        ray
    }

    fn vertices(function: &TransmittanceFunction<f32>) -> Vec<(f32, f64)> {
        function.vertices().iter().map(|vertex| (vertex.z, vertex.value[0])).collect()
    }

    #[test]
    fn two_half_opaque_surfaces_leave_a_quarter() {
        let function = TransmittanceFunction::new(&surfaces(&[(3.0, 0.5), (1.0, 0.5)]), 0.01);
        assert_eq!(vertices(&function), [(1.0, 1.0), (1.0, 0.5), (3.0, 0.5), (3.0, 0.25)]);
        assert_eq!((function.before(3.0), function.at(3.0)), ([0.5], [0.25]));
        assert_eq!((function.at(0.5), function.at(f32::INFINITY)), ([1.0], [0.25]));
        assert_eq!(function.at(f32::NAN), [1.0]);
        assert!(!function.is_curved());
    }

    #[test]
    fn equal_depths_are_one_step_and_clear_surfaces_none() {
        let hits = surfaces(&[(1.0, 0.5), (2.0, 0.0), (1.0, 0.5), (-0.0, 0.5), (0.0, 0.5)]);
        let function = TransmittanceFunction::new(&hits, 0.01);
        assert_eq!(vertices(&function), [(0.0, 1.0), (0.0, 0.25), (1.0, 0.25), (1.0, 0.0625)]);
    }

    #[test]
    fn nothing_follows_an_opaque_surface() {
        let mut hits = surfaces(&[(2.0, 1.0), (3.0, 0.5), (1.0, 0.5)]);
        hits.push_slab(2.5, 4.0, 0.5).unwrap();
        let function = TransmittanceFunction::new(&hits, 0.01);
        assert_eq!(vertices(&function), [(1.0, 1.0), (1.0, 0.5), (2.0, 0.5), (2.0, 0.0)]);
    }

    #[test]
    fn an_empty_ray_is_clear() {
        let function = TransmittanceFunction::<Rgb>::new(&RayHits::default(), 0.01);
        assert_eq!(function, TransmittanceFunction::default());
        assert_eq!((function.at(1.0), function.last()), ([1.0; 3], [1.0; 3]));
    }

    #[test]
    fn a_homogeneous_slab_needs_few_vertices() {
        // `fewest`: chords that each miss by exactly the error.
        for (extinction, error, fewest) in [
            (1.0, 1e-2, 8),
            (1.0, 1e-3, 21),
            (1.0, 1e-5, 195),
            (100.0, 1e-2, 9),
            (100.0, 1e-5, 225),
        ] {
            let mut hits = RayHits::<f32>::default();
            let slab = [1.0, 3.0].map(|depth| VolumeSample { depth, extinction });
            hits.push_volume(&slab, 2.0).unwrap();
            let function = TransmittanceFunction::new(&hits, error);
            assert!(function.is_curved());
            assert_eq!(function.vertices()[0], Vertex::new(1.0, [1.0]));
            for vertex in function.vertices() {
                let exact = (-2.0 * f64::from(extinction) * (f64::from(vertex.z) - 1.0)).exp();
                assert!((vertex.value[0] - exact).abs() < 1e-15);
            }
            let count = function.vertices().len();
            assert!(count <= fewest + fewest / 50 + 1, "{count}");
        }
    }
}
