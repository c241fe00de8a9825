//! All rays of a receiver against the fragments that they may meet.

use std::cmp::Reverse;
use std::marker::PhantomData;

use dsm_core::Transmittance;
use fearless_simd::{Simd, SimdBase, SimdMask, f32x16};

use super::apex::{Apex, Distances};
use super::cone::Cone;
use super::frontier::Frontier;
use super::lanes::Lanes;
use super::near_planes::{CELL, NearPlane};
use super::packed::PackedFragments;
use super::range_tree::{Block, ConeTest, RangeTree, RayTest, bits};
use super::visit_order::VisitOrder;

/// Blocks that wait to be visited. Keeps its memory: never more than 16 of each
/// of 12 levels.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stacks {
    /// With the rays that may meet each, and for which u.
    packet: Vec<(Block, u32, [f32; 2])>,
    ray: Vec<(Block, [f32; 2])>,
}

/// What packets are traced through.
#[derive(Clone, Copy)]
pub(crate) struct Stage<'a, T> {
    pub(crate) fragments: &'a PackedFragments,
    pub(crate) value: PhantomData<T>,
    pub(crate) tree: &'a RangeTree,
    pub(crate) apex: &'a Apex,
    /// Light below this is none.
    pub(crate) least: f32,
}

/// Where fewer rays of a packet than these are left in a block, they go on one by
/// one: its pixels are too small for them to share.
const ALONE: u32 = 4;

/// Takes from the light of `lanes` what the fragments of the map take for u in
/// the range of `cone`.
#[inline(always)]
pub(crate) fn trace<S: Simd, T: Transmittance>(
    simd: S,
    stage: &Stage<'_, T>,
    frontier: &Frontier,
    cone: &Cone,
    stacks: &mut Stacks,
    lanes: &mut Lanes,
) {
    if cone.is_empty() {
        return;
    }
    let Stage { tree, apex, .. } = *stage;
    let test = ConeTest::new(simd, cone);
    let Stacks { packet: stack, ray: ray_stack } = stacks;
    // What is near ends rays before they get to what is far.
    let order = VisitOrder::new(cone);
    let whole = [cone.near - cone.slack(), cone.far + cone.slack()];
    stack.clear();
    stack.extend(frontier.blocks().iter().map(|&block| (block, u32::from(u16::MAX), whole)));
    stack.sort_unstable_by_key(|(block, ..)| Reverse(order.distance(block.at)));
    while let Some((block, some, range)) = stack.pop() {
        let some = some & lanes.live;
        if some.count_ones() < ALONE {
            for lane in bits(some) {
                trace_alone(simd, stage, &test, block, ray_stack, lanes, lane);
            }
            continue;
        }
        if block.level == 0 {
            meet_block(simd, stage, &test, block, range, lanes);
            if lanes.live == 0 {
                return;
            }
            continue;
        }
        let overlap = tree.overlap(simd, block, &test);
        for node in order.farthest_first(overlap.lanes) {
            let over = tree.rays_over(simd, block, node as u32, apex.place, apex.w, lanes);
            if over & some != 0 {
                let range = [overlap.enter[node], overlap.leave[node]];
                stack.push((RangeTree::below(block, node as u32), over & some, range));
            }
        }
    }
}

/// One ray through what lies in a block.
#[inline(always)]
fn trace_alone<S: Simd, T: Transmittance>(
    simd: S,
    stage: &Stage<'_, T>,
    test: &ConeTest<S>,
    block: Block,
    stack: &mut Vec<(Block, [f32; 2])>,
    lanes: &mut Lanes,
    lane: usize,
) {
    let inverse = [lanes.inverse[0][lane], lanes.inverse[1][lane]];
    let test = RayTest::new(test, inverse, lanes.near[lane], lanes.far[lane], stage.apex.w);
    stack.clear();
    stack.push((block, [lanes.near[lane], lanes.far[lane]]));
    while let Some((block, range)) = stack.pop() {
        if block.level == 0 {
            if meet_block_alone(simd, stage, block, range, lanes, lane) {
                return;
            }
            continue;
        }
        let overlap = stage.tree.overlap_ray(simd, block, &test);
        for node in bits(overlap.lanes) {
            let range = [overlap.enter[node], overlap.leave[node]];
            stack.push((RangeTree::below(block, node as u32), range));
        }
    }
}

/// The fragments of a block against one ray for u in `range`, 16 at a time, as
/// [`Lanes::meet`] does for one fragment and 16 rays. Tells whether the ray has
/// ended.
#[inline(always)]
fn meet_block_alone<S: Simd, T: Transmittance>(
    simd: S,
    stage: &Stage<'_, T>,
    block: Block,
    [enter, leave]: [f32; 2],
    lanes: &mut Lanes,
    lane: usize,
) -> bool {
    let apex = stage.apex;
    let fragments = stage.fragments.block::<T>(block.at);
    let splat = |value| f32x16::splat(simd, value);
    let (one, last) = (splat(1.0), splat(7.0));
    let slope = [lanes.slope[0][lane], lanes.slope[1][lane]];
    let start = [lanes.start[0][lane], lanes.start[1][lane]];
    let [low, high] = [apex.w + enter, apex.w + leave];
    for group in 0..fragments.groups() {
        for chunk in bits(fragments.chunks(simd, group, low, high)) {
            let chunk = fragments.chunk::<T>(group, chunk);
            let some = chunk.planes(simd);
            let [along_x, along_y] = some.gradient;
            let Distances { step: [step_x, step_y], distance, doubtful, .. } =
                apex.distances(simd, block, &some);
            let closing = splat(1.0) - (along_x * slope[0] + along_y * slope[1]);
            let u = distance / closing;
            // As [`Lanes::meet`] tells it.
            let (x, y) = (u * slope[0] + apex.within[0], u * slope[1] + apex.within[1]);
            let within = x.simd_ge(-step_x)
                & x.simd_lt(one - step_x)
                & y.simd_ge(-step_y)
                & y.simd_lt(one - step_y);
            let (x, y) = (((x + step_x) * 8.0).min(last), ((y + step_y) * 8.0).min(last));
            let earliest = splat(start[0].min(start[1]));
            let met = within & u.simd_ge(earliest) & u.simd_lt(splat(lanes.end[lane]));
            let hits = met.to_bitmask() as u32 & some.lanes;
            if hits == 0 {
                continue;
            }
            let (u, x, y) = (u.to_array(), x.to_array(), y.to_array());
            let mut any = false;
            for at in bits(hits) {
                let bit = ((y[at] as u32) << 3) | x[at] as u32;
                let covered = chunk.coverage::<T>(at) >> (bit & 63) & 1 == 1;
                let covered = covered
                    && !(doubtful >> at & 1 == 1
                        && (u[at] * slope[0]).abs().max((u[at] * slope[1]).abs()) < CELL
                        && apex.surface.is_settled(NearPlane {
                            off: distance.to_array()[at],
                            slope: [along_x.to_array()[at], along_y.to_array()[at]],
                        }));
                if covered && u[at] >= start[usize::from(chunk.is_facing(at))] {
                    any = true;
                    lanes.take_alone::<T>(lane, |channel| chunk.opacity(at, channel));
                }
            }
            if any && lanes.stop_alone::<T>(lane, stage.least) {
                return true;
            }
        }
    }
    false
}

/// The fragments of a block against all rays, for u in `range`.
#[inline(always)]
fn meet_block<S: Simd, T: Transmittance>(
    simd: S,
    stage: &Stage<'_, T>,
    test: &ConeTest<S>,
    block: Block,
    [enter, leave]: [f32; 2],
    lanes: &mut Lanes,
) {
    let apex = stage.apex;
    let fragments = stage.fragments.block::<T>(block.at);
    let [low, high] = [apex.w + enter, apex.w + leave];
    for group in 0..fragments.groups() {
        for chunk in bits(fragments.chunks(simd, group, low, high)) {
            let chunk = fragments.chunk::<T>(group, chunk);
            let some = chunk.planes(simd);
            let [along_x, along_y] = some.gradient;
            let Distances { step, beyond: [beyond_x, beyond_y], distance, doubtful } =
                apex.distances(simd, block, &some);
            let away = some.w - apex.w;
            let reach = (along_x.abs() + along_y.abs()) * 0.502 + some.w.abs() * 2e-6;
            let (first, last) =
                test.in_pixels([-beyond_x, -beyond_y], [away - reach, away + reach]);
            let candidates = first.simd_le(last).to_bitmask() as u32 & some.lanes;
            if candidates == 0 {
                continue;
            }
            let distance = distance.to_array();
            let gradient = [along_x.to_array(), along_y.to_array()];
            let step = step.map(|step| step.to_array());
            let mut any = false;
            for at in bits(candidates) {
                let gradient = [gradient[0][at], gradient[1][at]];
                let place = ([step[0][at], step[1][at]], apex.within);
                let coverage = || chunk.coverage::<T>(at);
                let facing = chunk.is_facing(at);
                let mut met = lanes.meet(simd, place, distance[at], gradient, facing, coverage);
                if doubtful >> at & 1 == 1
                    && apex.surface.is_settled(NearPlane { off: distance[at], slope: gradient })
                {
                    met &= !lanes.is_near(simd, distance[at], gradient, CELL);
                }
                if met.to_bitmask() != 0 {
                    lanes.take::<S, T>(simd, met, |channel| chunk.opacity(at, channel));
                    any = true;
                }
            }
            if any {
                lanes.stop::<S, T>(simd, stage.least);
                if lanes.live == 0 {
                    return;
                }
            }
        }
    }
}
