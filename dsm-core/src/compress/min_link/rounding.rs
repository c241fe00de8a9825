//! Corners as they are stored: `f32` depths and values.

use super::hull::Point;
use crate::compress::side::Side;
use crate::transmittance::Transmittance;
use crate::visibility::vertex::Vertex;

/// Replaces `rounded` by the stored vertices of a path whose corners lie on `path`:
/// values do not rise, at most two corners stay at one depth, and the first and the
/// last value are those of the path.
///
/// Where a corner's depth is rounded, its value follows one of the lines that meet
/// there: the upper one where no value may become darker, the lower one where none may
/// become lighter, and else their mean.
pub(super) fn round<T: Transmittance>(path: &[Point], side: Side, rounded: &mut Vec<Vertex<T>>) {
    rounded.clear();
    let slope = |near: usize| {
        let [from, to] = [path[near], path[near + 1]];
        if to.z > from.z { (to.y - from.y) / (to.z - from.z) } else { f64::NEG_INFINITY }
    };
    let last = path.len().saturating_sub(1);
    let mut highest = 1.0_f32;
    for (index, corner) in path.iter().enumerate() {
        let is_end = index == 0 || index == last;
        let nearest = corner.z as f32;
        let z = match side {
            // A plateau is longer where it is the upper line of the two.
            Side::Lighter if is_end && f64::from(nearest) < corner.z => nearest.next_up(),
            Side::Darker if is_end && f64::from(nearest) > corner.z => nearest.next_down(),
            _ => nearest,
        };
        let moved = f64::from(z) - corner.z;
        let value = if is_end || moved == 0.0 {
            corner.y
        } else {
            let [near, far] = [slope(index - 1), slope(index)]
                .map(|slope| if slope.is_finite() { corner.y + slope * moved } else { corner.y });
            match side {
                Side::Both => 0.5 * (near + far),
                Side::Lighter => near.max(far),
                Side::Darker => near.min(far),
            }
        };
        let value = side.round(value).clamp(0.0, highest);
        highest = value;
        let is_third =
            rounded.len() >= 2 && rounded[rounded.len() - 2..].iter().all(|vertex| vertex.z == z);
        if is_third {
            rounded.pop();
        }
        rounded.push(Vertex::new(z, T::splat(value)));
    }
}
