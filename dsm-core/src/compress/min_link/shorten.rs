//! Values of corners amid what their corridor allows, with few bits.

use super::hull::Point;
use super::rungs::{Bounds, Rung};

/// The share of what a corner may be, around its middle, that a short number is looked
/// for in: what is nearer to the corridor's sides is farther from V.
const AMID: f64 = 0.5;

/// Replaces the values of all corners but the first and the last by short numbers near the
/// middle of what they may be, one after the other, while the others stay: no link
/// leaves the corridor. Where a corner has no choice it stays as it is. O(rungs +
/// corners).
pub(super) fn shorten(path: &mut [Point], rungs: &[Rung<[f64; 1]>], bounds: &Bounds) {
    let mut passed = Passed::default();
    for index in 1..path.len().saturating_sub(1) {
        let [near, corner, far] = [path[index - 1], path[index], path[index + 1]];
        let (mut low, mut high) = (far.y, near.y);
        passed.limit(rungs, bounds, near, corner, &mut [&mut low, &mut high], true);
        let [least, most] = passed.at(rungs, bounds, corner.z, [near.z, far.z]);
        (low, high) = (low.max(least), high.min(most));
        let mut ahead = passed;
        ahead.limit(rungs, bounds, far, corner, &mut [&mut low, &mut high], false);
        if low <= high {
            path[index].y = short(low, high);
        }
    }
}

/// The rungs whose start, and whose end, lies before the corner that comes next.
#[derive(Clone, Copy, Debug, Default)]
struct Passed {
    starts: usize,
    ends: usize,
}

impl Passed {
    /// Narrows what a corner's value may be, `[low, high]`, by the link to its neighbour
    /// `fixed`; moves on to the farther one of the two.
    fn limit(
        &mut self,
        rungs: &[Rung<[f64; 1]>],
        bounds: &Bounds,
        fixed: Point,
        corner: Point,
        limits: &mut [&mut f64; 2],
        is_before: bool,
    ) {
        let [from, to] = if is_before { [fixed.z, corner.z] } else { [corner.z, fixed.z] };
        let length = corner.z - fixed.z;
        // Where a line from the neighbour through a place of the corridor comes.
        let reach = |z: f64, y: f64| fixed.y + (y - fixed.y) * (length / (z - fixed.z));
        while let Some(rung) = rungs.get(self.starts).filter(|rung| rung.start < to) {
            self.starts += 1;
            if rung.start > from {
                let most = reach(rung.start, bounds.high(rung.after[0]));
                *limits[1] = if most < *limits[1] { most } else { *limits[1] };
            }
        }
        while let Some(rung) = rungs.get(self.ends).filter(|rung| rung.end < to) {
            self.ends += 1;
            if rung.end > from {
                let least = reach(rung.end, bounds.low(rung.before[0]));
                *limits[0] = if least > *limits[0] { least } else { *limits[0] };
            }
        }
    }

    /// What a path may be at `z`, the depth of the next corner, whose neighbours lie at
    /// `beside`: of a step on the corner's own side.
    fn at(&self, rungs: &[Rung<[f64; 1]>], bounds: &Bounds, z: f64, beside: [f64; 2]) -> [f64; 2] {
        match rungs.get(self.ends) {
            Some(rung) if rung.start <= z => {
                let (before, after) = (rung.before[0], rung.after[0]);
                let [upper, lower] = if beside[1] <= z {
                    [before; 2]
                } else if beside[0] >= z {
                    [after; 2]
                } else {
                    [before, after]
                };
                [bounds.low(upper), bounds.high(lower)]
            }
            Some(rung) => {
                let value = match self.ends.checked_sub(1).map(|near| &rungs[near]) {
                    Some(near) => {
                        let share = (z - near.end) / (rung.start - near.end);
                        near.after[0] + (rung.before[0] - near.after[0]) * share
                    }
                    None => 1.0,
                };
                [bounds.low(value), bounds.high(value)]
            }
            None => [bounds.last; 2],
        }
    }
}

/// A number between the two, amid them, with few bits behind the point.
fn short(low: f64, high: f64) -> f64 {
    let margin = 0.5 * (1.0 - AMID) * (high - low);
    let (from, to) = (low + margin, high - margin);
    // A width's largest power of two has a multiple within, and perhaps the next has.
    let step = f64::from_bits((to - from).max(f64::MIN_POSITIVE).to_bits() & (0x7ff << 52));
    for step in [4.0 * step, 2.0 * step, step] {
        let value = (0.5 * (low + high) / step).round() * step;
        if (from..=to).contains(&value) {
            return value;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_lie_between() {
        for (low, high) in [(0.0, 1.0), (0.3, 0.35), (0.7, 0.7 + 1e-9), (0.123, 0.4), (0.5, 0.5)] {
            let value = short(low, high);
            assert!((low..=high).contains(&value), "{value} of {low} to {high}");
        }
        assert_eq!(short(0.3, 0.4), 0.375);
        assert_eq!(short(0.45, 0.58), 0.5);
    }

    #[test]
    fn corners_stay_in_the_corridor() {
        let bounds = Bounds { below: 0.1, above: 0.1, last: 0.2 };
        let rung = |z: f64, before: f64, after: f64| Rung {
            start: z,
            end: z,
            before: [before],
            after: [after],
        };
        let rungs = [
            rung(1.0, 1.0, 1.0),
            rung(2.0, 0.8, 0.8),
            rung(3.0, 0.75, 0.5),
            rung(4.0, 0.4, 0.4),
            rung(5.0, 0.2, 0.2),
        ];
        let mut path = [(1.0, 1.0), (1.7, 0.87), (3.0, 0.712), (3.0, 0.456), (5.0, 0.2)]
            .map(|(z, y)| Point::new(z, y));
        shorten(&mut path, &rungs, &bounds);
        let line = |a: Point, b: Point, z: f64| a.y + (b.y - a.y) * (z - a.z) / (b.z - a.z);
        let found =
            [line(path[1], path[2], 2.0), path[2].y, path[3].y, line(path[3], path[4], 4.0)];
        for (found, value) in found.into_iter().zip([0.8, 0.75, 0.5, 0.4]) {
            assert!((found - value).abs() <= 0.1 + 1e-12, "{found} {value}");
        }
        assert!(path.windows(2).all(|pair| pair[0].y >= pair[1].y));
        assert!(path[1..4].iter().all(|corner| (corner.y * 64.0).fract() == 0.0), "{path:?}");
    }
}
