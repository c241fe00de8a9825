//! Compression of functions whose vertices are then rounded to grids, measured.

use super::compressor::{ChosenCompressor, Compression, Compressor};
use super::quantization::Quantization;
use super::short_path::{GridSearch, ShortPath};
use super::side::Side;
use crate::tolerance::Tolerance;
use crate::transmittance::Transmittance;
use crate::visibility::difference::VisibilityDifference;
use crate::visibility::vertex::{SumVertex, Vertex};

/// The shares of the tolerance that paths are drawn within before they are put on grids.
const SHARES: [f64; 4] = [0.97, 0.9, 0.82, 0.72];

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
    path: Vec<Vertex<T>>,
    trial: Vec<Vertex<T>>,
    best: ShortPath<T>,
}

impl<T: Transmittance> RoundedCompressor<T> {
    /// A compressor onto these grids; `None`: values and depths stay as they come.
    #[must_use]
    pub fn new(quantization: Option<Quantization>, compression: Compression) -> Self {
        let compressor = compression.compressor();
        Self {
            quantization,
            side: compression.side,
            compressor,
            stored: Vec::new(),
            path: Vec::new(),
            trial: Vec::new(),
            best: ShortPath::default(),
        }
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
        match self.quantization {
            None => {
                let mut emit = |vertex| vertices.push(vertex);
                self.compressor.compress(tolerance, exact, &mut emit);
            }
            Some(quantization) => self.round(quantization, tolerance, exact, vertices),
        }
        self.stored.clear();
        let stored = vertices[start..].iter();
        self.stored.extend(stored.map(|vertex| Vertex::new(vertex.z, vertex.value.to_sum())));
        let difference = VisibilityDifference::between(exact, &self.stored);
        let snap = |quantization: Quantization| quantization.snap_depths(vertices, start);
        Rounded { difference, moved: self.quantization.map_or(0.0, snap) }
    }
    /// Appends the path on grids that takes the fewest bits of those that are tried.
    fn round(
        &mut self,
        quantization: Quantization,
        tolerance: Tolerance,
        exact: &[SumVertex<T>],
        vertices: &mut Vec<Vertex<T>>,
    ) {
        let epsilon = f64::from(tolerance.epsilon());
        let step = Quantization::value_step(tolerance);
        let search = GridSearch { quantization, side: self.side, epsilon, step, exact };
        self.best.bits = f32::INFINITY;
        for share in SHARES {
            let narrower = tolerance.after((1.0 - share) * epsilon);
            self.path.clear();
            let path = &mut self.path;
            self.compressor.compress(narrower, exact, &mut |vertex| path.push(vertex));
            search.improve(&self.path, &mut self.trial, &mut self.best);
        }
        if self.best.bits < f32::INFINITY {
            vertices.append(&mut self.best.vertices);
            return;
        }
        let (start, rest) = (vertices.len(), Quantization::rest(tolerance, self.side));
        self.compressor.compress(rest, exact, &mut |vertex| vertices.push(vertex));
        Quantization::round_values(tolerance, self.side, vertices, start);
    }
}
