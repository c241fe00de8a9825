//! The fewest vertices of any path, by trying every place of a grid.

use dsm_core::detail::SumVertex;

/// The depths at which the oracle's paths may have vertices, beside those of V: whole
/// numbers up to this.
pub(crate) const GRID: u16 = 32;

/// What a path may be at one depth of the grid: on the light's side and behind.
#[derive(Clone, Copy)]
struct Place {
    z: f64,
    before: [f64; 2],
    behind: [f64; 2],
    /// Paths pass both without a vertex.
    both: [f64; 2],
}

/// Intervals of values that are reached.
type Reached = Vec<[f64; 2]>;

/// The fewest vertices that any polyline with steps within ε of the function can have
/// whose vertices stand at whole numbers or at one of `depths`: it is 1 up to the last vertex of V that is,
/// has the last value of V from the first vertex on that does, and may even rise in
/// between. By dynamic programming over every pair of depths, with all the intervals
/// of values that so many vertices reach. V's vertices stand at whole numbers.
pub(crate) fn fewest(vertices: &[SumVertex<f32>], epsilon: f64, depths: &[f64]) -> usize {
    let last = vertices[vertices.len() - 1].value[0];
    let first = vertices.iter().rposition(|vertex| vertex.value[0] == 1.0).unwrap();
    let end = vertices.iter().position(|vertex| vertex.value[0] == last).unwrap();
    if last == 1.0 {
        return 0;
    }
    let (first, end) = (f64::from(vertices[first].z), f64::from(vertices[end].z));
    let mut grid: Vec<f64> = (0..=GRID).map(f64::from).chain(depths.iter().copied()).collect();
    grid.sort_by(f64::total_cmp);
    grid.dedup();
    let places: Vec<Place> = grid
        .into_iter()
        .filter(|z| (first..=end).contains(z))
        .map(|z| place(vertices, epsilon, z, [first, end], last))
        .collect();
    let holds = |[low, high]: [f64; 2], value: f64| low <= value && value <= high;
    let plateau =
        |at: usize| places[..=at].iter().rev().skip(1).all(|place| holds(place.both, 1.0));
    let settled = |at: usize| places[at..].iter().skip(1).all(|place| holds(place.both, last));
    // With one vertex: where the path leaves 1.
    let mut before: Vec<Reached> = vec![Vec::new(); places.len()];
    for (at, place) in places.iter().enumerate() {
        if plateau(at) && holds(place.before, 1.0) {
            before[at].push([1.0; 2]);
        }
    }
    let mut behind: Vec<Reached> = vec![Vec::new(); places.len()];
    for count in 1.. {
        assert!(count <= vertices.len() + 2, "V itself is a path");
        // The last vertex is the far side of no step.
        for ((behind, before), place) in behind.iter_mut().zip(&before).zip(&places) {
            behind.extend(before.iter().filter_map(|&reached| within(reached, place.behind)));
        }
        let ends = |reached: &Reached| reached.iter().any(|&reached| holds(reached, last));
        if (0..places.len()).any(|at| {
            settled(at)
                && (ends(&behind[at]) || (holds(places[at].behind, last) && ends(&before[at])))
        }) {
            return count;
        }
        let mut next = vec![Vec::new(); places.len()];
        for (at, behind) in behind.iter().enumerate() {
            for source in merged(behind) {
                reach(&places, at, source, &mut next);
            }
        }
        // A vertical step there, up or down.
        behind = (0..places.len())
            .map(|at| if before[at].is_empty() { Vec::new() } else { vec![places[at].behind] })
            .collect();
        before = next.iter().map(merged).collect();
    }
    unreachable!("the loop returns");
}

fn place(
    vertices: &[SumVertex<f32>],
    epsilon: f64,
    z: f64,
    [first, end]: [f64; 2],
    last: f64,
) -> Place {
    let [value_before, value_behind] = crate::both_sides(vertices, 0, z as f32);
    let around = |value: f64| [(value - epsilon).max(last), (value + epsilon).min(1.0)];
    let before = if z == first { [1.0; 2] } else { around(value_before) };
    let behind = if z == end { [last; 2] } else { around(value_behind) };
    let both = [before[0].max(behind[0]), before[1].min(behind[1])];
    Place { z, before, behind, both }
}

fn within([low, high]: [f64; 2], [least, most]: [f64; 2]) -> Option<[f64; 2]> {
    let both = [low.max(least), high.min(most)];
    (both[0] <= both[1]).then_some(both)
}

fn merged(reached: &Reached) -> Reached {
    let mut sorted = reached.clone();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut merged: Reached = Vec::new();
    for [low, high] in sorted {
        match merged.last_mut() {
            Some(last) if low <= last[1] => last[1] = last[1].max(high),
            _ => merged.push([low, high]),
        }
    }
    merged
}

/// Adds what lines from `source` behind place `from` reach at every further place.
fn reach(places: &[Place], from: usize, source: [f64; 2], next: &mut [Reached]) {
    let z = places[from].z;
    let (mut floor, mut ceiling) = (vec![(z, source[0])], vec![(z, source[1])]);
    let through =
        |a: (f64, f64), b: (f64, f64), z: f64| a.1 + (b.1 - a.1) * (z - a.0) / (b.0 - a.0);
    let bounds =
        |floor: &[(f64, f64)], ceiling: &[(f64, f64)], z: f64, [mut low, mut high]: [f64; 2]| {
            for &under in floor {
                for &over in ceiling {
                    if under.0 < over.0 {
                        high = high.min(through(under, over, z));
                    } else if over.0 < under.0 {
                        low = low.max(through(over, under, z));
                    }
                }
            }
            [low, high]
        };
    for (at, place) in places.iter().enumerate().skip(from + 1) {
        let reached = bounds(&floor, &ceiling, place.z, place.before);
        if reached[0] > reached[1] {
            break;
        }
        next[at].push(reached);
        let [low, high] = bounds(&floor, &ceiling, place.z, place.both);
        if low > high {
            break;
        }
        floor.push((place.z, place.both[0]));
        ceiling.push((place.z, place.both[1]));
    }
}
