//! All rays of a cell against all primitives that may cover it.

use fearless_simd::{Simd, SimdBase, SimdMask, f32x16};

use super::cell_hits::CellHits;
use super::cells::{Cell, LANES};
use super::primitive::Primitive;

/// Appends to `cell_hits` what the rays of `cell` meet of the primitives that
/// `items` names, one after the other.
#[inline(always)]
pub(super) fn meet<S: Simd, P: Primitive>(
    simd: S,
    cell: &Cell,
    primitives: &[P],
    items: &[u32],
    cell_hits: &mut CellHits,
) {
    let near = f32x16::splat(simd, cell_hits.near);
    let infinity = f32x16::splat(simd, f32::INFINITY);
    let mut count = cell_hits.count;
    let (samples, depths) = (&mut cell_hits.samples[..], &mut cell_hits.depths[..]);
    for index in 0..cell.len() {
        let lanes = cell.lanes(simd, index);
        for &item in items {
            let (met, depth) = primitives[item as usize].meet(simd, &lanes);
            let met = met & depth.simd_gt(near) & depth.simd_lt(infinity);
            // Without a branch for those that meet none, which comes too often and
            // too seldom to be foretold.
            depth.compress(met).store_slice(&mut depths[count..count + LANES]);
            lanes.sample.compress(met).store_slice(&mut samples[count..count + LANES]);
            count += met.to_bitmask().count_ones() as usize;
            if cell_hits.keeps_items {
                cell_hits.items.push((item, count));
            }
        }
    }
    cell_hits.count = count;
}
