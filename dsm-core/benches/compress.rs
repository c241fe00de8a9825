//! Compression of whole functions: sheets, a pixel of hair, a smooth medium.
//! Items are input vertices.

#![expect(clippy::expect_used, reason = "a benchmark may panic")]

use divan::counter::ItemsCount;
use dsm_core::detail::{ChosenCompressor, Compressor, SumVertex, VisibilityDifference};
use dsm_core::{Compression, CompressionMethod, Rgb, Tolerance, Transmittance, Vertex};

const FUNCTIONS: u32 = 1000;
const EVENTS: u32 = 256;
const TOLERANCES: [f32; 4] = [0.1, 0.05, 0.02, 0.005];

fn main() {
    divan::main();
}

/// A hash of `index` in [0, 1).
fn uniform(index: u32) -> f64 {
    let mut bits = index.wrapping_mul(0x9E37_79B9) ^ 0x85EB_CA6B;
    for _ in 0..2 {
        bits = (bits ^ (bits >> 15)).wrapping_mul(0x2C1B_3C6D);
    }
    f64::from((bits ^ (bits >> 16)) >> 8) / f64::from(1 << 24)
}

/// The depths of `EVENTS` hits of one function, ascending and all different,
/// each with the ray that has it.
fn hits(function: u32) -> Vec<(f32, usize)> {
    let mut hits: Vec<_> = (0..EVENTS)
        .map(|hit| (1.0 + uniform(function * 1000 + hit) as f32, hit as usize % 16))
        .collect();
    hits.sort_by(|a, b| a.0.total_cmp(&b.0));
    for hit in 1..hits.len() {
        hits[hit].0 = hits[hit].0.max(hits[hit - 1].0.next_up());
    }
    hits
}

/// What is left of a channel after something of this opacity in red: green
/// and blue lose less, so that the channels differ.
fn pass(channel: usize, opacity: f64) -> f64 {
    1.0 - opacity / (1.0 + 0.3 * channel as f64)
}

/// Every hit stops a twentieth of what reaches it.
fn sheets<T: Transmittance>(function: u32) -> Vec<SumVertex<T>> {
    let mut left = T::CLEAR.to_sum();
    let step = |(z, _)| {
        let before = left;
        left = T::sum_from_channels(|channel| left.as_ref()[channel] * pass(channel, 0.05));
        [Vertex::new(z, before), Vertex::new(z, left)]
    };
    hits(function).into_iter().flat_map(step).collect()
}

/// 16 rays that each meet 16 hairs of opacity 0.3.
fn hair<T: Transmittance>(function: u32) -> Vec<SumVertex<T>> {
    let mut rays = [T::CLEAR.to_sum(); 16];
    let mut left = T::CLEAR.to_sum();
    let step = |(z, ray): (f32, usize)| {
        let (before, reached) = (left, rays[ray]);
        rays[ray] = T::sum_from_channels(|channel| reached.as_ref()[channel] * pass(channel, 0.3));
        left = T::sum_from_channels(|channel| {
            let lost = reached.as_ref()[channel] - rays[ray].as_ref()[channel];
            left.as_ref()[channel] - lost / 16.0
        });
        [Vertex::new(z, before), Vertex::new(z, left)]
    };
    hits(function).into_iter().flat_map(step).collect()
}

/// A medium of varying density, sampled at equal distances.
fn medium<T: Transmittance>(function: u32) -> Vec<SumVertex<T>> {
    let mut left = T::CLEAR.to_sum();
    let mut vertices = vec![Vertex::new(1.0, left)];
    vertices.extend((0..EVENTS).map(|sample| {
        let opacity = 0.05 * uniform(function * 1000 + 7777 + sample / 16);
        left = T::sum_from_channels(|channel| left.as_ref()[channel] * pass(channel, opacity));
        Vertex::new(1.0 + (sample as f32 + 0.5) / EVENTS as f32, left)
    }));
    vertices
}

const GREEDY: CompressionMethod = CompressionMethod::Greedy;
const MIN_LINK: CompressionMethod = CompressionMethod::MinLink;

fn run<T: Transmittance>(
    bencher: divan::Bencher,
    function: impl Fn(u32) -> Vec<SumVertex<T>>,
    method: CompressionMethod,
    epsilon: f32,
) {
    let tolerance = Tolerance::new(epsilon).expect("a valid tolerance");
    let functions: Vec<_> = (0..FUNCTIONS).map(function).collect();
    let mut compressor: ChosenCompressor<T> = Compression::new(method).compressor();
    let mut compressed: Vec<Vertex<T>> = Vec::new();
    for vertices in &functions {
        compressed.clear();
        compressor.compress(tolerance, vertices, &mut |vertex| compressed.push(vertex));
        let stored: Vec<SumVertex<T>> =
            compressed.iter().map(|vertex| Vertex::new(vertex.z, vertex.value.to_sum())).collect();
        let difference = VisibilityDifference::between(vertices, &stored).max();
        assert!(difference <= f64::from(epsilon), "{difference} is more than {epsilon}");
    }
    let input: usize = functions.iter().map(Vec::len).sum();
    bencher.counter(ItemsCount::new(input)).bench_local(|| {
        let mut written = 0_usize;
        for vertices in &functions {
            compressor.compress(tolerance, vertices, &mut |_| written += 1);
        }
        written
    });
}

#[divan::bench(args = TOLERANCES, types = [f32, Rgb])]
fn sheets_of_opacity<T: Transmittance>(bencher: divan::Bencher, epsilon: f32) {
    run::<T>(bencher, sheets::<T>, GREEDY, epsilon);
}

#[divan::bench(args = TOLERANCES, types = [f32, Rgb])]
fn hair_of_16_rays<T: Transmittance>(bencher: divan::Bencher, epsilon: f32) {
    run::<T>(bencher, hair::<T>, GREEDY, epsilon);
}

#[divan::bench(args = TOLERANCES, types = [f32, Rgb])]
fn smooth_medium<T: Transmittance>(bencher: divan::Bencher, epsilon: f32) {
    run::<T>(bencher, medium::<T>, GREEDY, epsilon);
}

#[divan::bench(args = TOLERANCES, types = [f32, Rgb])]
fn fewest_of_sheets<T: Transmittance>(bencher: divan::Bencher, epsilon: f32) {
    run::<T>(bencher, sheets::<T>, MIN_LINK, epsilon);
}

#[divan::bench(args = TOLERANCES, types = [f32, Rgb])]
fn fewest_of_hair<T: Transmittance>(bencher: divan::Bencher, epsilon: f32) {
    run::<T>(bencher, hair::<T>, MIN_LINK, epsilon);
}

#[divan::bench(args = TOLERANCES, types = [f32, Rgb])]
fn fewest_of_a_medium<T: Transmittance>(bencher: divan::Bencher, epsilon: f32) {
    run::<T>(bencher, medium::<T>, MIN_LINK, epsilon);
}
