//! Optical depth in coarse pixels, for what rays meet far from a receiver.

use dsm_core::Transmittance;
use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdInt, SimdMask, f32x16, i32x16};

use super::apex::Apex;
use super::exponential::exponential;
use super::lane_count::LANES;
use super::packed::PackedFragments;
use super::packet::Packet;

/// Slices between the least and the greatest w of a map.
const SLICES: usize = 64;

/// Columns hold one more border than slices, and one to interpolate from.
const COLUMN: usize = SLICES + 2;

/// Coarse pixels along the wider side of a map, at most.
const MOST_CELLS: u32 = 128;

/// The least pixels along the side of a coarse one.
const LEAST_SIDE: u32 = 4;

/// Steps of the stored numbers in an optical depth of 1.
const STEPS: f32 = 1024.0;

/// The most optical depth in one slice: a sixteenth of what 16 bits can tell
/// apart from what went before.
const MOST_DEPTH: f64 = 16.0;

/// How much optical depth a map's fragments make up on average in each coarse
/// pixel, from the least w on: what many fine fragments without connection,
/// such as strands and leaves, do to rays that come from somewhere else.
///
/// Sums wrap around: only differences count.
#[derive(Clone, Debug)]
pub(crate) struct FarTable {
    /// Pixels along the side of a coarse one.
    side: f32,
    /// In coarse pixels.
    size: [i32; 2],
    /// The w of the first border, and slices per unit of w.
    first: f32,
    scale: f32,
    /// For each channel, each coarse pixel, each border.
    sums: Vec<Vec<u16>>,
}

impl FarTable {
    /// The table of a map's `fragments`, which have w in `range`. O(fragments +
    /// coarse pixels).
    pub(crate) fn new<T: Transmittance>(fragments: &PackedFragments, range: [f32; 2]) -> Self {
        let [width, height] = fragments.size();
        let wide = width.max(height);
        let side = wide.div_ceil(MOST_CELLS).max(LEAST_SIDE);
        let size = [width, height].map(|pixels| pixels.div_ceil(side));
        let cells = size[0] as usize * size[1] as usize;
        let depths = f64::from(range[1]) - f64::from(range[0]);
        let scale = if depths > 0.0 { SLICES as f64 / depths } else { 0.0 };
        let squares = 64.0 * f64::from(side) * f64::from(side);
        let mut sums = Vec::new();
        let mut slices = vec![0.0; SLICES];
        let mut walls = Walls::new(side);
        for channel in 0..T::CHANNELS {
            let mut sum = vec![0_u16; cells * COLUMN];
            for (cell, column) in sum.chunks_exact_mut(COLUMN).enumerate() {
                let (x, y) = (cell as u32 % size[0] * side, cell as u32 / size[0] * side);
                slices.fill(0.0);
                walls.clear();
                let pixels = (y..y + side).flat_map(|y| (x..x + side).map(move |x| (x, y)));
                for (pixel, (x, y)) in pixels.enumerate() {
                    for fragment in fragments.pixel::<T>([x, y]) {
                        let covered = f64::from(fragment.coverage.count_ones()) / squares;
                        let opacity = f64::from(fragment.opacity.channel(channel));
                        let [low, high] = fragment.range().map(f64::from);
                        let slice = ((low + high) / 2.0 - f64::from(range[0])) * scale;
                        let slice = (slice.max(0.0) as usize).min(SLICES - 1);
                        slices[slice] -= (-opacity * covered).ln_1p();
                        if opacity == 1.0 {
                            walls.add(slice, pixel, fragment.coverage);
                        }
                    }
                }
                walls.close(&mut slices);
                let mut depth = 0.0;
                for (slice, border) in column.iter_mut().enumerate() {
                    // Wraps around, as all differences do.
                    *border = (depth * f64::from(STEPS)).round() as u64 as u16;
                    depth += slices.get(slice).map_or(0.0, |depth: &f64| depth.min(MOST_DEPTH));
                }
            }
            sums.push(sum);
        }
        Self {
            side: side as f32,
            size: size.map(|cells| cells as i32),
            first: range[0],
            scale: scale as f32,
            sums,
        }
    }

    /// How far u may go until a ray of this slope has moved by `cells` coarse
    /// pixels.
    pub(crate) fn reach(&self, cells: f32, slope: f32) -> f32 {
        cells * self.side / slope
    }

    /// What is left, for each channel, of the light of the rays of `packet`
    /// beyond `from`, up to their ends `end`; lanes that end before it keep 1.
    #[inline(always)]
    pub(crate) fn left<S: Simd>(
        &self,
        simd: S,
        apex: &Apex,
        packet: &Packet,
        from: f32,
        end: f32x16<S>,
    ) -> [f32x16<S>; 3] {
        let zero = f32x16::splat(simd, 0.0);
        let one = f32x16::splat(simd, 1.0);
        let per_side = self.side.recip();
        let place = apex.place.map(|at| at * per_side);
        // A slope of 0 has a border far away.
        let least = f32x16::splat(simd, packet.cone.least_slope() * per_side);
        let slope_x = away(f32x16::load_array_ref(simd, &packet.slope[0]) * per_side, least);
        let slope_y = away(f32x16::load_array_ref(simd, &packet.slope[1]) * per_side, least);
        let (inverse_x, inverse_y) = (one / slope_x, one / slope_y);
        // Where the map begins.
        let mut at = f32x16::splat(simd, from).max(f32x16::splat(simd, self.first - apex.w));
        let mut cell_x = (slope_x * at + place[0]).floor();
        let mut cell_y = (slope_y * at + place[1]).floor();
        let right = slope_x.simd_gt(zero);
        let down = slope_y.simd_gt(zero);
        let step_x = right.select(one, -one);
        let step_y = down.select(one, -one);
        let half = f32x16::splat(simd, 0.5);
        // The next border is the cell's farther side.
        let mut next_x = (cell_x + half + step_x * 0.5 - place[0]) * inverse_x;
        let mut next_y = (cell_y + half + step_y * 0.5 - place[1]) * inverse_y;
        let (width, height) = (self.size[0], self.size[1]);
        let mut depth = [zero; 3];
        // As many cells as a line can cross.
        for _ in 0..=2 * (width + height) {
            let live = at.simd_lt(end);
            if live.to_bitmask() == 0 {
                break;
            }
            let across = next_x.simd_lt(next_y);
            let to = across.select(next_x, next_y).max(at).min(end);
            let inside = cell_x.simd_ge(zero)
                & cell_x.simd_lt(f32x16::splat(simd, width as f32))
                & cell_y.simd_ge(zero)
                & cell_y.simd_lt(f32x16::splat(simd, height as f32))
                & live;
            if inside.to_bitmask() != 0 {
                let cell = inside.select(cell_y * (width as f32) + cell_x, zero);
                let (enter, enter_share) = self.border(simd, at, apex.w);
                let (leave, leave_share) = self.border(simd, to, apex.w);
                let cell: i32x16<S> = cell.to_int();
                let column = cell * COLUMN as i32;
                for (channel, sums) in self.sums.iter().enumerate() {
                    let crossed = differences(
                        simd,
                        sums,
                        (column + enter, enter_share),
                        (column + leave, leave_share),
                    );
                    depth[channel] += inside.select(crossed, zero);
                }
            }
            cell_x = across.select(cell_x + step_x, cell_x);
            cell_y = across.select(cell_y, cell_y + step_y);
            next_x = across.select(next_x + inverse_x.abs(), next_x);
            next_y = across.select(next_y, next_y + inverse_y.abs());
            // Lanes that are done stay where they are.
            at = live.select(to, at);
        }
        let mut left = [one; 3];
        for channel in 0..self.sums.len() {
            left[channel] = exponential(simd, depth[channel] * STEPS.recip());
        }
        left
    }

    /// The border at or before w + `u`, and how far beyond it that is.
    #[inline(always)]
    fn border<S: Simd>(&self, simd: S, u: f32x16<S>, w: f32) -> (i32x16<S>, f32x16<S>) {
        let zero = f32x16::splat(simd, 0.0);
        let last = f32x16::splat(simd, SLICES as f32);
        let at = ((u + (w - self.first)) * self.scale).max(zero).min(last);
        let border = at.floor();
        (border.to_int(), at - border)
    }
}

/// `slope`, or a small one.
#[inline(always)]
fn away<S: Simd>(slope: f32x16<S>, least: f32x16<S>) -> f32x16<S> {
    slope.abs().simd_lt(least).select(least, slope)
}

/// By how many steps the second interpolated sum is above the first.
#[inline(always)]
fn differences<S: Simd>(
    simd: S,
    sums: &[u16],
    (enter, enter_share): (i32x16<S>, f32x16<S>),
    (leave, leave_share): (i32x16<S>, f32x16<S>),
) -> f32x16<S> {
    let (enter, leave) = (enter.to_array(), leave.to_array());
    let mut between = [0_i32; LANES];
    let mut after_enter = [0_i32; LANES];
    let mut after_leave = [0_i32; LANES];
    for lane in 0..LANES {
        let [a, b] = pair(sums, enter[lane]);
        let [c, d] = pair(sums, leave[lane]);
        between[lane] = i32::from(c.wrapping_sub(a));
        after_enter[lane] = i32::from(b.wrapping_sub(a));
        after_leave[lane] = i32::from(d.wrapping_sub(c));
    }
    let float = |column: [i32; LANES]| i32x16::load_array(simd, column).to_float::<f32x16<S>>();
    float(between) + float(after_leave) * leave_share - float(after_enter) * enter_share
}

/// Two sums that follow each other; nothing outside.
#[inline(always)]
fn pair(sums: &[u16], at: i32) -> [u16; 2] {
    let at = at as usize;
    match sums.get(at..at + 2) {
        Some(two) => [two[0], two[1]],
        None => [0; 2],
    }
}

/// Opaque fragments of a coarse pixel that together leave no gap: sums of parts
/// would let light through.
struct Walls {
    /// Pixels of a coarse one.
    pixels: usize,
    /// Masks of all pixels, slice by slice.
    masks: Vec<u64>,
    /// Covered squares of a slice, counted again where they overlap.
    counts: Vec<u32>,
}

impl Walls {
    /// Slices that a slanted wall may pass within one coarse pixel.
    const SPAN: usize = 3;

    fn new(side: u32) -> Self {
        let pixels = (side * side) as usize;
        Self { pixels, masks: vec![0; SLICES * pixels], counts: vec![0; SLICES] }
    }

    fn clear(&mut self) {
        for (slice, count) in self.counts.iter_mut().enumerate() {
            if *count > 0 {
                self.masks[slice * self.pixels..(slice + 1) * self.pixels].fill(0);
                *count = 0;
            }
        }
    }

    fn add(&mut self, slice: usize, pixel: usize, coverage: u64) {
        self.masks[slice * self.pixels + pixel] |= coverage;
        self.counts[slice] += coverage.count_ones();
    }

    /// Blocks the light where few slices leave no gap.
    fn close(&self, slices: &mut [f64]) {
        let firsts = slices.iter_mut().enumerate().take(SLICES - Self::SPAN + 1);
        for (first, depth) in firsts {
            let some = first..first + Self::SPAN;
            let count: u32 = self.counts[some.clone()].iter().sum();
            if (count as usize) < 64 * self.pixels || self.counts[first] == 0 {
                continue;
            }
            let whole = (0..self.pixels).all(|pixel| {
                let mask = |slice| self.masks[slice * self.pixels + pixel];
                some.clone().fold(0, |all, slice| all | mask(slice)) == u64::MAX
            });
            if whole {
                *depth = MOST_DEPTH;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::super::columns::FragmentColumns;
    use super::super::fragment::Fragment;
    use super::super::map::FragmentMap;
    use super::super::oracle::frame;
    use super::super::packet::Starts;
    use super::*;
    use dsm_core::Facing;
    use dsm_trace::ShadowRay;
    use dsm_trace::detail::walk_every_pixel;
    use fearless_simd::{Level, dispatch};
    use glam::DVec3;

    /// The same sum cell by cell in `f64`, for one ray.
    fn naive(table: &FarTable, apex: &Apex, slope: [f64; 2], from: f64, end: f64) -> f64 {
        let side = f64::from(table.side);
        let place = apex.place.map(|at| f64::from(at) / side);
        let from = from.max(f64::from(table.first) - f64::from(apex.w));
        let at = |u: f64| [0, 1].map(|axis| place[axis] + slope[axis] / side * u);
        let ray = ShadowRay::new(at(from), from, slope.map(|along| along / side), end);
        let mut depth = 0.0;
        let size = table.size.map(|cells| cells as u32);
        walk_every_pixel(size, &ray, &mut |[x, y]: [u32; 2], enter: f64, leave: f64| {
            let column = &table.sums[0][(y * size[0] + x) as usize * COLUMN..][..COLUMN];
            let sum = |u: f64| {
                let w = f64::from(apex.w) + u - f64::from(table.first);
                let at = (w * f64::from(table.scale)).clamp(0.0, SLICES as f64);
                let border = at as usize;
                let [low, high] = [column[border], column[border + 1]].map(f64::from);
                low + (high - low) * (at - border as f64)
            };
            depth += sum(leave) - sum(enter);
            ControlFlow::Continue(())
        });
        (-depth / f64::from(STEPS)).exp()
    }

    #[test]
    fn marching_equals_the_sum_over_all_cells() {
        // Thin enough not to wrap, so that the naive sum needs no care.
        let size = [150, 70];
        let mut columns = FragmentColumns::new();
        for pixel in 0..size[0] * size[1] {
            let fragment = Fragment {
                w: 0.25 + (pixel % 101) as f32 / 200.0,
                gradient: Some([0.0; 2]),
                opacity: 0.25 + (pixel % 3) as f32 / 4.0,
                coverage: u64::MAX >> (pixel % 60),
            };
            columns.push_pixel((pixel % 7 < 4).then_some(fragment)).unwrap();
        }
        let frame = frame(size, 0.0);
        let map = FragmentMap::new(frame, columns).unwrap();
        let fragments = PackedFragments::new(&map).unwrap();
        let table = FarTable::new::<f32>(&fragments, [0.25, 0.75]);
        let range = [0.25, 0.75];
        let mut dark = 0;
        for index in 0..60 {
            let shift = f64::from(index) / 60.0 - 0.5;
            let receiver = DVec3::new(2.0 * shift, 1.3 * shift, -4.5);
            let apex = Apex::new(&frame, receiver, Facing::Light).unwrap().without_surface();
            let lights: Vec<_> = (0..16)
                .map(|at| DVec3::new(0.3 * f64::from(at % 4) - 0.4, 0.2 * f64::from(at / 4), 0.0))
                .collect();
            let starts = Starts::Distances([0.0; 2]);
            let from = 0.1 * shift.abs() as f32;
            let (packet, left) = dispatch!(Level::new(), simd => {
                let packet = Packet::new(simd, &frame, &apex, &lights, starts, range);
                let end = f32x16::load_array(simd, packet.end);
                let left = table.left(simd, &apex, &packet, from, end)[0].to_array();
                (packet, left)
            });
            for (lane, &left) in left.iter().enumerate() {
                let slope = [0, 1].map(|axis| f64::from(packet.slope[axis][lane]));
                let end = f64::from(packet.end[lane]);
                let expected = naive(&table, &apex, slope, from.into(), end);
                assert!((f64::from(left) - expected).abs() < 2e-4, "{index} {left} {expected}");
                dark += u32::from(left < 0.9);
            }
        }
        assert!(dark > 300, "{dark}");
    }

    #[test]
    fn exponentials_are_those_of_the_library() {
        for step in 0..2000 {
            let x = step as f32 * 0.01;
            let ours = dispatch!(Level::new(), simd => {
                exponential(simd, f32x16::splat(simd, x)).to_array()[0]
            });
            assert!((ours - (-x).exp()).abs() <= 2e-6 * (-x).exp() + 1e-30, "{x}: {ours}");
        }
    }
}
