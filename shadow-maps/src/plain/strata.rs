//! The taps of a percentage closer filter: one in every cell of a square grid.

use dsm_core::detail::random::MIX32_FACTORS;
use dsm_core::detail::random::mix32;
use fearless_simd::{Bytes, Simd, SimdBase, SimdFloat, SimdInt, SimdMask, f32x16, i32x16, u32x16};

use super::tap_region::{DepthPlane, TapRegion};

/// Taps that are done at once.
const LANES: usize = 16;

/// Values of a jitter along one axis.
const JITTERS: f32 = 65536.0;

/// n × n cells of the unit square.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Strata {
    /// The cells' left and upper edges, in columns of a multiple of 16.
    left: Vec<f32>,
    top: Vec<f32>,
    /// Takes a jitter to a part of a cell's side.
    step: f32,
    count: u32,
}

impl Strata {
    /// `side` × `side` cells, at most 64 × 64. Where that goes, 4 × 4 cells
    /// stand together, which lie in fewer rows of the map than 16 × 1.
    pub(crate) fn new(side: u32) -> Self {
        let block = if side.is_multiple_of(4) { 4 } else { 1 };
        let blocks = side / block;
        let cells = (0..side * side).map(|index| {
            let (within, block_index) = (index % (block * block), index / (block * block));
            let column = block_index % blocks * block + within % block;
            let row = block_index / blocks * block + within / block;
            [column, row].map(|number| number as f32 / side as f32)
        });
        let cells: Vec<[f32; 2]> = cells.collect();
        let column = |axis: usize| {
            let mut column: Vec<f32> = cells.iter().map(|cell| cell[axis]).collect();
            column.resize(cells.len().next_multiple_of(LANES), 0.0);
            column
        };
        let step = (side as f32 * JITTERS).recip();
        Self { left: column(0), top: column(1), step, count: side * side }
    }

    /// Number of cells.
    pub(crate) const fn count(&self) -> u32 {
        self.count
    }

    /// How many taps of `region` are behind `plane`, one tap after the other.
    pub(crate) fn lit_scalar(
        &self,
        depths: &[f32],
        region: &TapRegion,
        plane: &DepthPlane,
        seed: u32,
    ) -> u32 {
        let mut lit = 0;
        for index in 0..self.count {
            let bits = mix32(seed.wrapping_add(index));
            let jitter = [bits & 0xffff, bits >> 16].map(|bits| bits as f32 * self.step);
            let u = self.left[index as usize] + jitter[0];
            let v = self.top[index as usize] + jitter[1];
            let x = region.corner[0] + u * region.extent[0];
            let y = region.corner[1] + v * region.extent[1];
            // A rounding may reach the map's edge.
            let column = (region.first[0] + x as u32).min(region.last[0]);
            let row = (region.first[1] + y as u32).min(region.last[1]);
            let depth = depths[(row * region.pitch + column) as usize];
            lit += u32::from(depth > plane.corner + u * plane.across + v * plane.down);
        }
        lit
    }

    /// The same, 16 at a time: the same operations in the same order.
    #[inline(always)]
    pub(crate) fn lit<S: Simd>(
        &self,
        simd: S,
        depths: &[f32],
        region: &TapRegion,
        plane: &DepthPlane,
        seed: u32,
    ) -> u32 {
        let mut numbers = [0_u32; LANES];
        numbers.iter_mut().zip(0..).for_each(|(number, lane)| *number = lane);
        let mut number = u32x16::load_array(simd, numbers) + u32x16::splat(simd, seed);
        let real = |value: f32| f32x16::splat(simd, value);
        let whole = |value: u32| i32x16::splat(simd, value as i32);
        let [corner_x, corner_y] = region.corner.map(real);
        let [width, height] = region.extent.map(real);
        let [first_x, first_y] = region.first.map(whole);
        let [last_x, last_y] = region.last.map(whole);
        let pitch = whole(region.pitch);
        let step = real(self.step);
        let low = u32x16::splat(simd, 0xffff);
        let factors = MIX32_FACTORS.map(|factor| u32x16::splat(simd, factor));
        let (plane_corner, across, down) =
            (real(plane.corner), real(plane.across), real(plane.down));
        let mut lit = 0;
        let mut left_over = self.count;
        for (left, top) in self.left.chunks_exact(LANES).zip(self.top.chunks_exact(LANES)) {
            let mut bits = number;
            bits = (bits ^ (bits >> 16)) * factors[0];
            bits = (bits ^ (bits >> 15)) * factors[1];
            bits = bits ^ (bits >> 16);
            number += u32x16::splat(simd, LANES as u32);
            // Below 2¹⁶, so the same as signed numbers, whose conversion is
            // cheap everywhere.
            let jitter = [bits & low, bits >> 16]
                .map(|bits| bits.bitcast::<i32x16<S>>().to_float::<f32x16<S>>() * step);
            let u = f32x16::from_slice(simd, left) + jitter[0];
            let v = f32x16::from_slice(simd, top) + jitter[1];
            let x = corner_x + u * width;
            let y = corner_y + v * height;
            let column = (first_x + x.to_int::<i32x16<S>>()).min(last_x);
            let row = (first_y + y.to_int::<i32x16<S>>()).min(last_y);
            let index = (row * pitch + column).to_array();
            let depth = index.map(|index| depths.get(index as usize).copied().unwrap_or(0.0));
            let depth = f32x16::load_array(simd, depth);
            let behind = depth.simd_gt(plane_corner + u * across + v * down);
            let asked = (1_u64 << left_over.min(LANES as u32)) - 1;
            lit += (behind.to_bitmask() & asked).count_ones();
            left_over = left_over.saturating_sub(LANES as u32);
        }
        lit
    }
}
