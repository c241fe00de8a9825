//! Functions of seven kinds, compressed in every way.

use std::time::Instant;

use anyhow::{Result, ensure};
use dsm_core::detail::{
    Compressor, PixelLists, Quantization, RoundedCompressor, SumVertex, VisibilityDifference,
    paper_greedy,
};
use dsm_core::{
    Compression, CompressionMethod, PixelListsBuilder, Tolerance, Transmittance, Vertex,
};
use dsm_io::detail::EncodedTile;
use dsm_io::{Codec, Packing};
use dsm_testkit::FunctionKind;

use crate::figures::seconds;

/// Pixels along the side of a tile.
const SIDE: u32 = 16;

/// Rounds of which times are the median.
const ROUNDS: usize = 3;

/// Seconds that a method works in a round at least: clocks of a thread may tick slowly.
const LEAST_SECONDS: f64 = 0.15;

/// The compressors of the library.
pub(super) const METHODS: [CompressionMethod; 2] =
    [CompressionMethod::Greedy, CompressionMethod::MinLink];

/// What one compressor leaves of the functions of one kind, for one number of samples.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Outcome {
    /// Vertices a function.
    pub(super) vertices: f64,
    /// The mean of V′ − V over depth and functions, in tolerances.
    pub(super) shade: f64,
    /// The square root of the mean of (V′ − V)², in tolerances.
    pub(super) distance: f64,
    /// Nanoseconds for a vertex of V.
    pub(super) nanoseconds: f64,
    /// Bytes a pixel in a tile of codec `exact`, block zstd.
    pub(super) exact: f64,
    /// Vertices a function, and bytes a pixel, of codec `quantized`.
    pub(super) quantized: [f64; 2],
}

/// All about one kind, for one number of samples.
#[derive(Clone, Debug)]
pub(super) struct Kind {
    pub(super) kind: FunctionKind,
    pub(super) samples: u32,
    /// Vertices of V, and of the paper's compressor.
    pub(super) vertices: [f64; 2],
    pub(super) outcomes: [Outcome; 2],
}

impl Kind {
    /// Compresses a tile of functions of a kind at the paper's tolerance; an error if a
    /// compressor breaks it.
    pub(super) fn measure(kind: FunctionKind, samples: u32) -> Result<Self> {
        let tolerance = Tolerance::for_samples(samples);
        let mut tiles = METHODS.map(|method| [Tile::new(method, None), quantized(method)]);
        let mut kept = Vec::new();
        let mut vertices = [0.0; 2];
        let count = SIDE * SIDE;
        for seed in 0..count {
            let function = kind.function::<f32>(samples, seed.into());
            let paper = paper_greedy::<f32>(&function, tolerance);
            vertices[0] += function.len() as f64 / f64::from(count);
            vertices[1] += paper.len() as f64 / f64::from(count);
            for tile in tiles.iter_mut().flatten() {
                tile.push(tolerance, &function)?;
            }
            if seed % 16 == 0 {
                kept.push(function);
            }
        }
        let times = times(tolerance, &kept);
        let mut outcomes = [Outcome::default(); 2];
        for ((outcome, [exact, quantized]), time) in outcomes.iter_mut().zip(tiles).zip(times) {
            *outcome = exact.finish(Codec::Exact, tolerance)?;
            let rounded = quantized.finish(Codec::Quantized, tolerance)?;
            outcome.quantized = [rounded.vertices, rounded.exact];
            outcome.nanoseconds = time;
        }
        Ok(Self { kind, samples, vertices, outcomes })
    }
}

/// A tile while its functions are compressed.
struct Tile {
    compressor: RoundedCompressor<f32>,
    is_rounded: bool,
    lists: PixelListsBuilder<f32>,
    vertices: Vec<Vertex<f32>>,
    shade: f64,
    square: f64,
}

fn quantized(method: CompressionMethod) -> Tile {
    Tile::new(method, Some(Quantization::default()))
}

impl Tile {
    fn new(method: CompressionMethod, quantization: Option<Quantization>) -> Self {
        Self {
            compressor: RoundedCompressor::new(quantization, Compression::new(method)),
            is_rounded: quantization.is_some(),
            lists: PixelListsBuilder::new(SIDE, SIDE),
            vertices: Vec::new(),
            shade: 0.0,
            square: 0.0,
        }
    }

    fn push(&mut self, tolerance: Tolerance, exact: &[SumVertex<f32>]) -> Result<()> {
        self.vertices.clear();
        let rounded = self.compressor.compress(tolerance, exact, &mut self.vertices);
        let stored: Vec<SumVertex<f32>> = self
            .vertices
            .iter()
            .map(|vertex| Vertex::new(vertex.z, vertex.value.to_sum()))
            .collect();
        let off = if self.is_rounded {
            VisibilityDifference::with_moved_depths(stored.as_slice(), exact, rounded.moved).max()
        } else {
            VisibilityDifference::between(exact, stored.as_slice()).max()
        };
        ensure!(off <= f64::from(tolerance.epsilon()), "off by {off} of {tolerance:?}");
        let (shade, square) = deviation(exact, &stored);
        self.shade += shade;
        self.square += square;
        self.vertices.iter().for_each(|&vertex| self.lists.push(vertex));
        Ok(self.lists.finish_pixel()?)
    }

    fn finish(self, codec: Codec, tolerance: Tolerance) -> Result<Outcome> {
        let pixels: PixelLists<f32> = self.lists.finish()?;
        let tile = EncodedTile::encode(pixels.view(), codec, Packing::Zstd)?;
        let (count, epsilon) = (f64::from(SIDE * SIDE), f64::from(tolerance.epsilon()));
        Ok(Outcome {
            vertices: pixels.view().vertex_count() as f64 / count,
            shade: self.shade / count / epsilon,
            distance: (self.square / count).sqrt() / epsilon,
            exact: tile.bytes.len() as f64 / count,
            ..Outcome::default()
        })
    }
}

/// Nanoseconds that each method takes for a vertex of V: one method after the other in
/// every round, so that what else runs meets both.
fn times(tolerance: Tolerance, functions: &[Vec<SumVertex<f32>>]) -> [f64; 2] {
    let start = Instant::now();
    let count: usize = functions.iter().map(Vec::len).sum();
    let mut compressors = METHODS.map(|method| Compression::new(method).compressor::<f32>());
    let mut taken = [const { Vec::new() }; 2];
    let mut written = 0_usize;
    for _ in 0..ROUNDS {
        for (compressor, taken) in compressors.iter_mut().zip(&mut taken) {
            let (before, mut passes) = (seconds(start), 0);
            let spent = loop {
                // Many vertices between two looks at the clock.
                for function in (0..=20_000 / count).flat_map(|_| functions) {
                    compressor.compress(tolerance, function, &mut |_| written += 1);
                }
                passes += 1 + 20_000 / count;
                let spent = seconds(start) - before;
                if spent >= LEAST_SECONDS {
                    break spent;
                }
            };
            taken.push(spent * 1e9 / (passes * count) as f64);
        }
    }
    std::hint::black_box(written);
    taken.map(|mut taken| {
        taken.sort_by(f64::total_cmp);
        taken[ROUNDS / 2]
    })
}

/// The means of V′ − V and of its square over the depths of V.
fn deviation(exact: &[SumVertex<f32>], stored: &[SumVertex<f32>]) -> (f64, f64) {
    let (Some(first), Some(last)) = (exact.first(), exact.last()) else { return (0.0, 0.0) };
    let (start, end) = (f64::from(first.z), f64::from(last.z));
    if end <= start {
        return (0.0, 0.0);
    }
    // Between vertices of either both are linear.
    let between = |function: &[SumVertex<f32>], next: usize, z: f64| {
        let Some(near) = next.checked_sub(1).map(|near| &function[near]) else { return 1.0 };
        let Some(far) = function.get(next) else { return near.value[0] };
        let length = f64::from(far.z) - f64::from(near.z);
        let share = if length > 0.0 { (z - f64::from(near.z)) / length } else { 1.0 };
        near.value[0] + (far.value[0] - near.value[0]) * share
    };
    let behind = |function: &[SumVertex<f32>], z: f64| {
        function.partition_point(|vertex| f64::from(vertex.z) <= z)
    };
    let (mut z, mut sum, mut square) = (start, 0.0, 0.0);
    while z < end {
        let next = [behind(stored, z), behind(exact, z)];
        let depth = |function: &[SumVertex<f32>], next: usize| {
            function.get(next).map_or(end, |vertex| f64::from(vertex.z))
        };
        let to = depth(stored, next[0]).min(depth(exact, next[1])).min(end);
        let off = |z: f64| between(stored, next[0], z) - between(exact, next[1], z);
        let (from, until) = (off(z), off(to));
        sum += (to - z) * 0.5 * (from + until);
        square += (to - z) * (from * from + from * until + until * until) / 3.0;
        z = to;
    }
    (sum / (end - start), square / (end - start))
}
