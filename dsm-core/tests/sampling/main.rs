//! From the hits of rays to an uncompressed visibility function, against
//! closed forms and naive evaluation in f64.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod average;
#[path = "../support/mod.rs"]
mod support;
mod sweep;
mod transmittance;

use dsm_core::Transmittance;
use dsm_core::detail::SumVertex;

/// Holds vertices to the invariant of visibility functions.
fn check_invariant<T: Transmittance>(vertices: &[SumVertex<T>]) {
    let value = |index: usize, channel: usize| vertices[index].value.as_ref()[channel];
    for channel in 0..T::CHANNELS {
        if !vertices.is_empty() {
            assert_eq!(value(0, channel), 1.0, "the first value");
            assert!(value(vertices.len() - 1, channel) >= 0.0, "the last value");
        }
        for index in 1..vertices.len() {
            assert!(value(index, channel) <= value(index - 1, channel), "rise at {index}");
        }
    }
    for pair in vertices.windows(2) {
        assert!(pair[0].z <= pair[1].z, "order: {pair:?}");
        assert!(pair[0] != pair[1], "twice the same vertex: {pair:?}");
    }
    for three in vertices.windows(3) {
        assert!(three[0].z < three[2].z, "three at one depth: {three:?}");
    }
    assert!(vertices.iter().all(|vertex| vertex.z >= 0.0 && vertex.z.is_finite()));
}

/// Depths that tell on a function: those given, their neighbours, some between
/// and some beyond; all f32, the only depths that can be asked for.
fn telling_depths(mut depths: Vec<f32>) -> Vec<f32> {
    depths.extend([0.0, f32::from_bits(1), f32::MAX]);
    depths.sort_by(f32::total_cmp);
    depths.dedup();
    let between = depths.windows(2).flat_map(|pair| {
        let (near, far) = (f64::from(pair[0]), f64::from(pair[1]));
        [0.03, 0.25, 0.5, 0.75, 0.97].map(|share| (near + (far - near) * share) as f32)
    });
    let neighbours = depths.iter().flat_map(|z| [z.next_up(), z.next_down()]);
    let mut all: Vec<f32> = depths.iter().copied().chain(between).chain(neighbours).collect();
    all.retain(|z| *z >= 0.0 && z.is_finite());
    all
}
