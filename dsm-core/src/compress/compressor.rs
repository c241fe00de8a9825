//! Compressors of whole functions, and the choice among them.

use super::greedy::{End, GreedyCompressor};
use crate::tolerance::Tolerance;
use crate::transmittance::Transmittance;
use crate::visibility::vertex::{SumVertex, Vertex};

/// A compressor of visibility functions under an L∞ bound.
pub trait Compressor<T: Transmittance> {
    /// Passes the vertices of a V′ with |V′ − V| ≤ ε, in `f32` values, to `emit`,
    /// for the V of `vertices`, which keep the invariant of visibility functions
    /// and end with V(∞): V′ ends with it too, rounded, and keeps the invariant.
    fn compress(
        &mut self,
        tolerance: Tolerance,
        vertices: &[SumVertex<T>],
        emit: &mut impl FnMut(Vertex<T>),
    );
}

/// The choice of a compressor, for bakes, conversions and mip levels.
///
/// ```
/// use dsm_core::{Tolerance, Vertex};
/// use dsm_core::detail::{Compression, Compressor};
///
/// // Ten sheets that each stop a twentieth of the light.
/// let left = |sheets: u8| [f64::from(20 - sheets) / 20.0];
/// let steps = (1..=10_u8).flat_map(|sheet| {
///     [left(sheet - 1), left(sheet)].map(|value| Vertex::new(f32::from(sheet), value))
/// });
/// let exact: Vec<_> = steps.collect();
/// let mut compressed: Vec<Vertex<f32>> = Vec::new();
/// let tolerance = Tolerance::new(0.06)?;
/// Compression::default().compress(tolerance, &exact, &mut |vertex| compressed.push(vertex));
/// assert_eq!(compressed, [Vertex::new(1.0, 1.0), Vertex::new(10.0, 0.5)]);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Compression {
    /// One pass, O(1) a vertex ([`GreedyCompressor`]).
    #[default]
    Greedy,
}

impl<T: Transmittance> Compressor<T> for Compression {
    #[inline]
    fn compress(
        &mut self,
        tolerance: Tolerance,
        vertices: &[SumVertex<T>],
        emit: &mut impl FnMut(Vertex<T>),
    ) {
        match self {
            Self::Greedy => {
                if let Some(last) = vertices.last() {
                    let end = End::Known(last.value);
                    let mut compressor = GreedyCompressor::new(tolerance, end);
                    compressor.push_all(vertices, emit);
                    compressor.finish(emit);
                }
            }
        }
    }
}
