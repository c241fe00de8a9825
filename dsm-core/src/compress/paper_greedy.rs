//! The compressor of the paper, as a baseline.

use super::slope_window::{SlopeWindow, Target};
use crate::tolerance::Tolerance;
use crate::transmittance::Transmittance;
use crate::visibility::vertex::{SumVertex, Vertex};

/// The greedy algorithm exactly as Lokovic & Veach 2000, §3.3, describe it: a
/// baseline for comparisons, not for maps. It starts at (0, 1), lets segments
/// rise, clamps nothing, ends wherever the last slope leads, and does not
/// round to `f32`. So what it returns need not be a visibility function; at
/// the vertices of `vertices` it is within ε of them.
///
/// `vertices` are those of a visibility function. O(n).
#[must_use]
pub fn paper_greedy<T: Transmittance>(
    vertices: &[SumVertex<T>],
    tolerance: Tolerance,
) -> Vec<SumVertex<T>> {
    if vertices.is_empty() {
        return Vec::new();
    }
    let epsilon = f64::from(tolerance.epsilon());
    let target = Target::<T> {
        down: epsilon,
        up: epsilon,
        floor: T::sum_from_channels(|_| f64::NEG_INFINITY),
    };
    let mut compressed = vec![Vertex::new(0.0, T::CLEAR.to_sum())];
    let mut window = SlopeWindow::from_origin(compressed[0], &target);
    for vertex in vertices {
        if window.narrow_by(vertex) {
            continue;
        }
        if window.is_open() {
            compressed.push(window.end());
            window = SlopeWindow::from_origin(window.end(), &target);
            if window.narrow_by(vertex) {
                continue;
            }
        }
        // At the origin's depth the slope is infinite: through the middle of
        // the target window, unless the origin lies within.
        let origin = window.origin();
        let mut both = origin.value.as_ref().iter().zip(vertex.value.as_ref());
        if both.any(|(from, to)| (from - to).abs() > epsilon) {
            compressed.push(*vertex);
            window = SlopeWindow::from_origin(*vertex, &target);
        }
    }
    if window.is_open() {
        compressed.push(window.end());
    }
    compressed
}
