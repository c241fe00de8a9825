//! Density along a ray through a volume.

use dsm_core::Ray;
use glam::{DVec3, IVec3};

use crate::volume::{Cell, Volume};

/// The density at a parameter of the ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DensitySample {
    pub(crate) t: f64,
    pub(crate) density: f32,
}

/// Middles this close to the line between their neighbours, relative to the
/// densities, are left out.
const STRAIGHT: f64 = 1e-7;

/// Pieces that a cell is cut into at most.
const MAX_PIECES: u32 = 8;

/// Calls `stretch` with the density along every stretch of the ray, given in
/// the object's space, that may hold any: front to back, linear between
/// samples.
///
/// Within a cell the density along the ray is a cubic. Every cell gives a
/// sample at its end and one in its middle, which is chosen so that the two
/// trapezia have the cubic's integral (Simpson's rule): the optical depth is
/// exact, up to rounding, wherever the ray leaves a cell, unless that would
/// take a negative density. Where the integral up to some point within the cell
/// would be off by more than `within`, the cell is cut into up to
/// [`MAX_PIECES`] pieces of which the same holds.
pub(crate) fn march(
    volume: &Volume,
    ray: &Ray,
    within: f64,
    samples: &mut Vec<DensitySample>,
    mut stretch: impl FnMut(&[DensitySample]),
) {
    let origin = volume.to_index(ray.origin());
    let direction = volume.direction_to_index(ray.direction());
    let bounds = volume.index_bounds();
    let Some((enter, leave)) = bounds.clip(origin, direction) else { return };
    let [near, far] = ray.range();
    let (mut t, far) = (enter.max(near), leave.min(far));
    let [first, last] = [bounds.min.as_ivec3(), bounds.max.as_ivec3() - 1];
    let at = |t: f64| origin + direction * t;
    let mut cell = at(t).floor().as_ivec3().clamp(first, last);
    samples.clear();
    while t < far {
        let (start, side, occupied) = volume.block(cell);
        let (exit, axis) = exit(origin, direction, start, side);
        let end = exit.max(t).min(far);
        let corners = if occupied { volume.cell(cell) } else { Cell::EMPTY };
        if corners.is_empty() {
            flush(samples, &mut stretch);
        } else if end > t {
            let density = |t: f64| corners.at(at(t) - cell.as_dvec3());
            push_cell(samples, [t, end], within, density);
        }
        t = end;
        let onward = direction[axis] > 0.0;
        let previous = cell;
        if side > 1 {
            cell = at(t).floor().as_ivec3().clamp(start, start + side - 1);
            // Rounding must not lead back.
            let ahead = direction.cmpge(DVec3::ZERO);
            cell = IVec3::select(ahead, cell.max(previous), cell.min(previous));
        }
        cell[axis] = if onward { start[axis] + side } else { start[axis] - 1 };
        if cell[axis] < first[axis] || cell[axis] > last[axis] {
            break;
        }
    }
    flush(samples, &mut stretch);
}

/// The parameter where the line leaves the box of cells, and the side it leaves
/// through.
#[inline]
fn exit(origin: DVec3, direction: DVec3, start: IVec3, side: i32) -> (f64, usize) {
    let mut nearest = (f64::INFINITY, 0);
    for axis in 0..3 {
        let far = if direction[axis] > 0.0 { start[axis] + side } else { start[axis] };
        let t = (f64::from(far) - origin[axis]) / direction[axis];
        if direction[axis] != 0.0 && t < nearest.0 {
            nearest = (t, axis);
        }
    }
    nearest
}

fn push_cell(
    samples: &mut Vec<DensitySample>,
    [t, end]: [f64; 2],
    within: f64,
    density: impl Fn(f64) -> f32,
) {
    if samples.is_empty() {
        samples.push(DensitySample { t, density: density(t) });
    }
    let pieces = pieces([t, end], within, &density);
    let step = (end - t) / f64::from(pieces);
    let mut begin = t;
    for piece in 1..=pieces {
        let end = if piece == pieces { end } else { t + step * f64::from(piece) };
        push_piece(samples, [begin, end], &density);
        begin = end;
    }
}

/// Number of pieces of the cubic between `begin` and `end` that are off by at most
/// `within` each.
fn pieces([begin, end]: [f64; 2], within: f64, density: &impl Fn(f64) -> f32) -> u32 {
    if within == f64::INFINITY {
        return 1;
    }
    let half = 0.5 * (end - begin);
    let at = |part: f64| f64::from(density(begin + half * (1.0 + part)));
    // The cubic over [−1, 1], from four of its values.
    let [first, early, middle, last] = [-1.0, -0.5, 0.0, 1.0].map(at);
    let square = 0.5 * (first + last) - middle;
    let odd = 0.5 * (last - first);
    let cube = (odd - 2.0 * (middle + 0.25 * square - early)) * (4.0 / 3.0);
    // What the two trapezia are off by: at a third of each half, and in the
    // middle. In n pieces, at least n³ times less.
    let off = half * (square.abs() * (4.0 / 81.0) + cube.abs() * 0.25);
    (off / within).cbrt().ceil().clamp(1.0, f64::from(MAX_PIECES)) as u32
}

/// Adds the middle and the end of a piece that begins with the last sample.
fn push_piece(samples: &mut Vec<DensitySample>, [t, end]: [f64; 2], density: &impl Fn(f64) -> f32) {
    let middle = 0.5 * (t + end);
    let from = samples.last().map_or(0.0, |sample| sample.density);
    let [through, to] = [middle, end].map(density);
    let simpson = (8.0 * f64::from(through) - f64::from(from) - f64::from(to)) / 6.0;
    push(samples, DensitySample { t: middle, density: simpson.max(0.0) as f32 });
    push(samples, DensitySample { t: end, density: to });
}

/// Adds a sample, in place of the last one if that lies on the line to it.
#[inline]
fn push(samples: &mut Vec<DensitySample>, next: DensitySample) {
    if let [.., before, last] = samples.as_slice() {
        let part = (last.t - before.t) / (next.t - before.t);
        let [a, b, c] = [before, last, &next].map(|sample| f64::from(sample.density));
        if (a + (c - a) * part - b).abs() <= STRAIGHT * a.max(b).max(c) {
            samples.pop();
        }
    }
    samples.push(next);
}

fn flush(samples: &mut Vec<DensitySample>, stretch: &mut impl FnMut(&[DensitySample])) {
    if samples.len() > 1 {
        stretch(samples);
    }
    samples.clear();
}

/// The integral of density over t.
pub(crate) fn integral(samples: &[DensitySample]) -> f64 {
    let trapezium = |pair: &[DensitySample]| {
        let mean = 0.5 * (f64::from(pair[0].density) + f64::from(pair[1].density));
        mean * (pair[1].t - pair[0].t)
    };
    samples.windows(2).map(trapezium).sum()
}
