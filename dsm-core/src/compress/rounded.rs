//! Compression of functions whose vertices are then rounded to grids, measured.

use super::compressor::{ChosenCompressor, Compression, Compressor};
use super::quantization::Quantization;
use super::side::Side;
use crate::tolerance::Tolerance;
use crate::transmittance::Transmittance;
use crate::visibility::difference::VisibilityDifference;
use crate::visibility::vertex::{SumVertex, Vertex};

/// What became of a function that was compressed.
#[derive(Clone, Copy, Debug)]
pub struct Rounded {
    /// Its difference from what it was, beside the shift of depths.
    pub difference: VisibilityDifference,
    /// The largest shift of a depth away from the light, in scene units.
    pub moved: f32,
}

/// A compressor that rounds to grids what it leaves, if there are any, and measures
/// both in `f64` on the `f32` values. Keeps its memory from one function to the next.
#[derive(Debug)]
pub struct RoundedCompressor<T: Transmittance> {
    quantization: Option<Quantization>,
    side: Side,
    compressor: ChosenCompressor<T>,
    stored: Vec<SumVertex<T>>,
}

impl<T: Transmittance> RoundedCompressor<T> {
    /// A compressor onto these grids; `None`: values and depths stay as they come.
    #[must_use]
    pub fn new(quantization: Option<Quantization>, compression: Compression) -> Self {
        let compressor = compression.compressor();
        Self { quantization, side: compression.side, compressor, stored: Vec::new() }
    }

    /// Appends the compressed function of `exact` to `vertices`. Values are off by
    /// `tolerance` at most, and depths lie no nearer to the light.
    pub fn compress(
        &mut self,
        tolerance: Tolerance,
        exact: &[SumVertex<T>],
        vertices: &mut Vec<Vertex<T>>,
    ) -> Rounded {
        let start = vertices.len();
        let mut emit = |vertex| vertices.push(vertex);
        match self.quantization {
            None => self.compressor.compress(tolerance, exact, &mut emit),
            Some(_) => {
                let rest = Quantization::rest(tolerance, self.side);
                self.compressor.compress(rest, exact, &mut emit);
                Quantization::round_values(tolerance, self.side, vertices, start);
            }
        }
        self.stored.clear();
        let stored = vertices[start..].iter();
        self.stored.extend(stored.map(|vertex| Vertex::new(vertex.z, vertex.value.to_sum())));
        let difference = VisibilityDifference::between(exact, &self.stored);
        let snap = |quantization: Quantization| quantization.snap_depths(vertices, start);
        Rounded { difference, moved: self.quantization.map_or(0.0, snap) }
    }
}
