//! Paths whose corners lie on coarse grids, verified: short numbers for small files.

use super::extent::Extent;
use super::quantization::Quantization;
use super::side::Side;
use crate::transmittance::Transmittance;
use crate::visibility::vertex::{SumVertex, Vertex};

/// Bits of an `f32` behind the point.
const MANTISSA: u32 = f32::MANTISSA_DIGITS - 1;

/// What a lookup rounds by, and `f32` values once more.
const VALUE_ROUNDING: f64 = 1.0 / (1 << 24) as f64;

/// A path on grids, and about how many bits a file needs for it.
#[derive(Clone, Debug)]
pub(super) struct ShortPath<T> {
    pub(super) vertices: Vec<Vertex<T>>,
    pub(super) bits: f32,
}

impl<T> Default for ShortPath<T> {
    fn default() -> Self {
        Self { vertices: Vec::new(), bits: f32::INFINITY }
    }
}

/// The search for the coarsest grid of a pixel's corners that keeps to the tolerance.
///
/// Values become multiples of [`Quantization::value_step`]. Corners between two slopes
/// are moved to the nearest depths with `shift` zeros at the end of their bits, to either
/// side, and their values follow the lines that meet there; both within ε, which is
/// measured. Steps stay where they are.
#[derive(Clone, Debug)]
pub(super) struct GridSearch<'a, T: Transmittance> {
    pub(super) quantization: Quantization,
    pub(super) side: Side,
    pub(super) epsilon: f64,
    pub(super) step: f32,
    pub(super) exact: &'a [SumVertex<T>],
}

impl<T: Transmittance> GridSearch<'_, T> {
    /// Leaves in `best` the path on the coarsest grid that is found to keep to the
    /// tolerance, if one is found and takes fewer bits than what is there. O(n + m) a
    /// grid, of which a handful are tried.
    pub(super) fn improve(
        &self,
        path: &[Vertex<T>],
        trial: &mut Vec<Vertex<T>>,
        best: &mut ShortPath<T>,
    ) {
        let bits = path.iter().map(|vertex| self.quantization.bits(vertex.z)).max();
        // On this grid corners lie anyway.
        let finest = MANTISSA - bits.unwrap_or(MANTISSA).min(MANTISSA);
        let has_corners = (0..path.len()).any(|index| !is_step(path, index));
        let mut shift = if has_corners { self.likely_shift(path).max(finest) } else { 0 };
        let mut coarsest = MANTISSA - 1;
        while !self.is_kept(path, shift, trial) {
            if shift == 0 {
                return;
            }
            coarsest = shift - 1;
            shift = if shift > finest { shift - 1 } else { 0 };
        }
        loop {
            let bits = self.bits(trial, shift.max(finest));
            if bits < best.bits {
                best.bits = bits;
                best.vertices.clone_from(trial);
            }
            if !has_corners || shift >= coarsest || !self.is_kept(path, shift + 1, trial) {
                return;
            }
            shift += 1;
        }
    }

    /// The grid on which moving a corner changes values by about a quarter of ε.
    fn likely_shift(&self, path: &[Vertex<T>]) -> u32 {
        let corners = (0..path.len()).filter(|&index| !is_step(path, index));
        let shifts = corners.map(|index| {
            let bends = (0..T::CHANNELS).map(|channel| {
                let [near, far] = slopes(path, index, channel);
                (near - far).abs()
            });
            let z = path[index].z + 0.0;
            let unit = f64::from(f32::from_bits(z.to_bits() + 1)) - f64::from(z);
            let change = bends.fold(0.0, f64::max) * unit;
            let units = self.epsilon / change.max(self.epsilon * 1e-9);
            // The exponent: a logarithm, rounded down.
            ((units.to_bits() >> 52) as u32).saturating_sub(1023)
        });
        shifts.min().unwrap_or(0).min(MANTISSA - 1)
    }

    /// Puts the path on the grid of `shift` into `trial`; true if that keeps to the
    /// tolerance.
    fn is_kept(&self, path: &[Vertex<T>], shift: u32, trial: &mut Vec<Vertex<T>>) -> bool {
        self.place(path, shift, trial);
        let extent = Extent::of(self.exact, trial);
        let [below, above] = self
            .side
            .shares()
            .map(|share| if share > 0.0 { self.epsilon * share - VALUE_ROUNDING } else { 0.0 });
        extent.below <= below && extent.above <= above
    }

    fn place(&self, path: &[Vertex<T>], shift: u32, placed: &mut Vec<Vertex<T>>) {
        placed.clear();
        let Some(end) = path.last() else { return };
        let lowest = self.rounded(|channel| f64::from(end.value.channel(channel)));
        let (mut highest, mut nearest) = (T::CLEAR, 0.0_f32);
        for (index, &Vertex { z, value }) in path.iter().enumerate() {
            // Not −0.
            let mut depth = z + 0.0;
            if !is_step(path, index) {
                let next = path.get(index + 1).filter(|_| is_step(path, index + 1));
                let farthest = next.map_or(f32::MAX, |next| next.z);
                depth = multiple_between(z, shift, nearest, farthest);
            }
            nearest = depth;
            let moved = f64::from(depth) - f64::from(z);
            let is_end = index == 0 || index + 1 == path.len();
            let followed = self.rounded(|channel| {
                let value = f64::from(value.channel(channel));
                if moved == 0.0 || is_end {
                    value
                } else {
                    value + moved * self.slope_at(path, index, channel)
                }
            });
            highest = T::from_channels(|channel| {
                let least = followed.channel(channel).max(lowest.channel(channel));
                least.min(highest.channel(channel))
            });
            push(placed, Vertex::new(depth, highest));
        }
        // What is constant needs no vertex behind it.
        if let [.., near, last] = placed.as_slice()
            && near.value == last.value
        {
            placed.pop();
        }
        if placed.last().is_none_or(|last| last.value == T::CLEAR) {
            placed.clear();
        }
    }

    /// The slope along which the value of a corner follows when it is moved.
    fn slope_at(&self, path: &[Vertex<T>], index: usize, channel: usize) -> f64 {
        let [near, far] = slopes(path, index, channel);
        0.5 * (near + far)
    }

    /// Values on the grid, to the side.
    fn rounded(&self, value: impl Fn(usize) -> f64) -> T {
        let step = f64::from(self.step);
        T::from_channels(|channel| {
            let steps = value(channel) / step;
            let whole = match self.side {
                Side::Both => steps.round(),
                Side::Lighter => steps.ceil(),
                Side::Darker => steps.floor(),
            };
            (whole * step).clamp(0.0, 1.0) as f32
        })
    }

    /// About how many bits a file needs for a path whose corners lie on the grid of
    /// `shift`.
    fn bits(&self, path: &[Vertex<T>], shift: u32) -> f32 {
        let size = |count: f32| (1.0 + count).log2();
        let mut sum = 0.0;
        let mut before: Option<Vertex<T>> = None;
        for (index, vertex) in path.iter().enumerate() {
            let from = before.map_or(T::CLEAR, |before| before.value);
            for channel in 0..T::CHANNELS {
                sum += size((from.channel(channel) - vertex.value.channel(channel)) / self.step);
            }
            let own = MANTISSA - self.quantization.bits(vertex.z).min(MANTISSA);
            let zeros = if is_step(path, index) { own } else { shift };
            match before {
                Some(before) if before.z >= vertex.z => {}
                Some(before) => {
                    let moved = vertex.z.to_bits() - before.z.to_bits();
                    sum += 4.5 + size((moved >> zeros) as f32);
                }
                None => sum += 22.0 - zeros as f32,
            }
            before = Some(*vertex);
        }
        sum
    }
}

/// True if a vertex shares its depth with a neighbour.
fn is_step<T: Transmittance>(path: &[Vertex<T>], index: usize) -> bool {
    let z = path[index].z;
    let at = |index: Option<usize>| {
        index.and_then(|index| path.get(index)).is_some_and(|vertex| vertex.z == z)
    };
    at(index.checked_sub(1)) || at(Some(index + 1))
}

/// The slopes before and behind a vertex, 0 beyond the ends.
fn slopes<T: Transmittance>(path: &[Vertex<T>], index: usize, channel: usize) -> [f64; 2] {
    let slope = |near: Option<&Vertex<T>>, far: Option<&Vertex<T>>| match (near, far) {
        (Some(near), Some(far)) if far.z > near.z => {
            let fall =
                f64::from(far.value.channel(channel)) - f64::from(near.value.channel(channel));
            fall / (f64::from(far.z) - f64::from(near.z))
        }
        _ => 0.0,
    };
    let before = index.checked_sub(1).and_then(|before| path.get(before));
    let behind = path.get(index + 1);
    [slope(before, Some(&path[index])), slope(Some(&path[index]), behind)]
}

/// The nearest depth whose bits end with `shift` zeros, between two others if there is
/// one; else `z`, which lies between them, or the nearer of them.
fn multiple_between(z: f32, shift: u32, nearest: f32, farthest: f32) -> f32 {
    let bits = (z + 0.0).to_bits();
    let half = if shift > 0 { 1 << (shift - 1) } else { 0 };
    let round = |bits: u32| f32::from_bits((bits >> shift) << shift);
    let candidates = [round(bits + half), round(bits), round(bits + 2 * half)];
    let fits = |depth: &f32| (nearest..=farthest).contains(depth);
    candidates.into_iter().find(fits).unwrap_or_else(|| z.max(nearest))
}

/// Appends a vertex and drops what says nothing between its neighbours.
fn push<T: Transmittance>(placed: &mut Vec<Vertex<T>>, vertex: Vertex<T>) {
    if let [.., last] = placed.as_slice()
        && *last == vertex
    {
        return;
    }
    if placed.len() == 1 && vertex.value == T::CLEAR {
        placed.pop();
    }
    if let [.., first, second] = placed.as_slice()
        && (first.z == vertex.z || first.value == vertex.value && second.value == first.value)
    {
        placed.pop();
    }
    placed.push(vertex);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compress::compressor::{Compression, CompressionMethod};
    use crate::compress::rounded::RoundedCompressor;
    use crate::random::{combine, mix, unit};
    use crate::tolerance::Tolerance;

    fn hashed_unit(seed: u64, number: u64) -> f64 {
        unit(mix(combine(seed, number)))
    }

    /// Many small falls at odd depths, and a large one.
    fn function(seed: u64) -> Vec<SumVertex<f32>> {
        let mut vertices = Vec::new();
        let (mut z, mut value) = (3.0_f32, 1.0_f64);
        for index in 0..60 {
            z += 0.001 + 0.05 * hashed_unit(seed, index) as f32;
            let fall = if index == 40 { 0.2 } else { 0.02 * hashed_unit(seed, 100 + index) };
            for value in [value, value - fall] {
                vertices.push(Vertex::new(z, [value.max(0.0)]));
            }
            value -= fall;
        }
        vertices
    }

    #[test]
    fn corners_lie_on_coarse_grids_within_the_tolerance_on_every_side() {
        let tolerance = Tolerance::new(0.05).unwrap();
        for side in [Side::Both, Side::Lighter] {
            let compression = Compression::new(CompressionMethod::MinLink).with_side(side);
            let quantization = Quantization::default();
            let mut compressor = RoundedCompressor::new(Some(quantization), compression);
            let (mut zeros, mut corners) = (0, 0);
            for seed in 0..200 {
                let exact = function(seed);
                let mut vertices: Vec<Vertex<f32>> = Vec::new();
                let rounded = compressor.compress(tolerance, &exact, &mut vertices);
                let extent = Extent::of(&exact, &vertices);
                assert!(rounded.difference.max() <= 0.05);
                // Steps alone were moved, by less than a 16,384th: never so that it is darker.
                assert!(extent.below <= if side == Side::Both { 0.05 } else { 0.0 }, "{extent:?}");
                let own = (0..vertices.len()).filter(|&index| !is_step(&vertices, index));
                for index in own {
                    zeros += vertices[index].z.to_bits().trailing_zeros();
                    corners += 1;
                }
            }
            // The grid of steps has 9.
            assert!(corners > 400 && zeros > 13 * corners, "{zeros} of {corners}");
        }
    }

    #[test]
    fn moved_corners_stay_between_their_neighbours() {
        let near = multiple_between(1.3, 20, 0.0, 9.0);
        assert_eq!(near, 1.25);
        assert_eq!(multiple_between(1.3, 20, 1.26, 9.0), 1.375);
        assert_eq!(multiple_between(1.3, 20, 1.26, 1.31), 1.3);
        assert_eq!(multiple_between(-0.0, 20, 0.0, 9.0), 0.0);
    }
}
