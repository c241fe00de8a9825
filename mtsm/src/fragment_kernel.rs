//! All rays of a receiver against the fragments that they may meet.

use std::marker::PhantomData;

use dsm_core::Transmittance;
use fearless_simd::{Simd, SimdBase, SimdMask, f32x16};

use crate::fragment::is_facing;
use crate::packed_fragments::{PackedFragments, PixelFragments};
use crate::packet::{Apex, Lanes, Packet};
use crate::range_tree::{Block, Cone, ConeTest, LANES, PacketRays, RangeTree, RayTest, inverse};

/// Blocks that a group of rays is narrowed to before its packets look.
const FRONTIER: usize = 6;

/// Blocks that wait to be visited. Keeps its memory: never more than 16 of each
/// of 12 levels.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stacks {
    /// With the rays that may meet each.
    packet: Vec<(Block, u32)>,
    ray: Vec<Block>,
}

/// The blocks that a group of rays from one apex may meet: empty where all are
/// clear.
#[derive(Clone, Debug, Default)]
pub(crate) struct Frontier {
    blocks: Vec<Block>,
    next: Vec<Block>,
}

impl Frontier {
    /// Goes down while the blocks stay few.
    #[inline(always)]
    pub(crate) fn fill<S: Simd>(&mut self, simd: S, tree: &RangeTree, cone: &Cone) {
        self.blocks.clear();
        if cone.is_empty() {
            return;
        }
        let test = ConeTest::new(simd, cone);
        self.blocks.push(tree.root());
        while let Some(first) = self.blocks.first().filter(|block| block.level > 0) {
            let level = first.level;
            self.next.clear();
            for &block in &self.blocks {
                let mut lanes = tree.overlap(simd, block, &test).lanes;
                while lanes != 0 {
                    self.next.push(RangeTree::below(block, lanes.trailing_zeros()));
                    lanes &= lanes - 1;
                }
            }
            if self.next.len() > FRONTIER {
                return;
            }
            std::mem::swap(&mut self.blocks, &mut self.next);
            if level == 1 {
                break;
            }
        }
        // The last word on small groups: are there pixels at all?
        if self.blocks.len() <= 4 && self.blocks.iter().all(|block| block.level == 0) {
            self.blocks.retain(|&block| tree.overlap(simd, block, &test).lanes != 0);
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }
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

/// Rays of a packet that go on one by one: where fewer than these are left in a
/// block, its pixels are too small for them to share.
const ALONE: u32 = 5;

/// Takes from the light of `lanes` what the fragments of the map take for u in
/// the range of `cone`. Tells whether no light is left.
#[inline(always)]
pub(crate) fn trace<S: Simd, T: Transmittance>(
    simd: S,
    stage: &Stage<'_, T>,
    frontier: &Frontier,
    cone: &Cone,
    stacks: &mut Stacks,
    lanes: &mut Lanes<S>,
) -> bool {
    if cone.is_empty() {
        return false;
    }
    let Stage { tree, apex, least, .. } = *stage;
    let test = ConeTest::new(simd, cone);
    let slack = f32x16::splat(simd, cone.slack());
    let rays = PacketRays {
        inverse: [inverse(simd, lanes.slope[0]), inverse(simd, lanes.slope[1])],
        near: lanes.start[0].min(lanes.start[1]) - slack,
        far: lanes.end + slack,
    };
    let Stacks { packet: stack, ray: ray_stack } = stacks;
    for &start in &frontier.blocks {
        stack.clear();
        stack.push((start, u32::from(u16::MAX)));
        while let Some((block, some)) = stack.pop() {
            if some.count_ones() < ALONE {
                if trace_alone(simd, stage, &test, &rays, (block, some), ray_stack, lanes) {
                    return true;
                }
                continue;
            }
            let overlap = tree.overlap(simd, block, &test);
            let mut nodes = overlap.lanes;
            while nodes != 0 {
                let node = nodes.trailing_zeros();
                nodes &= nodes - 1;
                let below = RangeTree::below(block, node);
                if block.level > 0 {
                    let over = tree.rays_over(simd, block, node, apex.place, apex.w, &rays);
                    if over & some != 0 {
                        stack.push((below, over & some));
                    }
                    continue;
                }
                let range = [overlap.enter[node as usize], overlap.leave[node as usize]];
                let pixel = (below.at, stage.fragments.pixel(block, node));
                if meet_pixel(simd, stage, pixel, range, lanes) && lanes.stop::<T>(simd, least) {
                    return true;
                }
            }
        }
    }
    false
}

/// The same for the rays in `some` and what lies in one block, ray by ray.
#[inline(always)]
fn trace_alone<S: Simd, T: Transmittance>(
    simd: S,
    stage: &Stage<'_, T>,
    test: &ConeTest<S>,
    rays: &PacketRays<S>,
    (block, mut some): (Block, u32),
    stack: &mut Vec<Block>,
    lanes: &mut Lanes<S>,
) -> bool {
    let inverse = rays.inverse.map(|column| column.to_array());
    let (near, far) = (rays.near.to_array(), rays.far.to_array());
    let slope = lanes.slope.map(|column| column.to_array());
    let start = lanes.start.map(|column| column.to_array());
    let mut end = lanes.end.to_array();
    let mut left = lanes.left.map(|column| column.to_array());
    let mut any = false;
    while some != 0 {
        let lane = some.trailing_zeros() as usize;
        some &= some - 1;
        if end[lane] < 0.0 {
            continue;
        }
        let ray_inverse = [inverse[0][lane], inverse[1][lane]];
        let ray = RayTest::new(test, ray_inverse, near[lane], far[lane], stage.apex.w);
        let mut one = OneRay {
            slope: [slope[0][lane], slope[1][lane]],
            start: [start[0][lane], start[1][lane]],
            end: end[lane],
            left: [left[0][lane], left[1][lane], left[2][lane]],
        };
        if trace_ray(simd, stage, &ray, block, stack, &mut one) {
            any = true;
            for (column, value) in left.iter_mut().zip(one.left) {
                column[lane] = value;
            }
            end[lane] = one.end;
        }
    }
    if any {
        lanes.left = left.map(|column| f32x16::load_array(simd, column));
        lanes.end = f32x16::load_array(simd, end);
        return end.iter().all(|&end| end < 0.0);
    }
    false
}

/// One ray of a packet.
struct OneRay {
    slope: [f32; 2],
    start: [f32; 2],
    end: f32,
    left: [f32; 3],
}

/// One ray through what lies in a block. Tells whether it met anything.
#[inline(always)]
fn trace_ray<S: Simd, T: Transmittance>(
    simd: S,
    stage: &Stage<'_, T>,
    test: &RayTest<S>,
    block: Block,
    stack: &mut Vec<Block>,
    ray: &mut OneRay,
) -> bool {
    stack.clear();
    stack.push(block);
    let mut any = false;
    while let Some(block) = stack.pop() {
        let overlap = stage.tree.overlap_ray(simd, block, test);
        let mut nodes = overlap.lanes;
        while nodes != 0 {
            let node = nodes.trailing_zeros();
            nodes &= nodes - 1;
            let below = RangeTree::below(block, node);
            if block.level > 0 {
                stack.push(below);
                continue;
            }
            let range = [overlap.enter[node as usize], overlap.leave[node as usize]];
            let pixel = (below.at, stage.fragments.pixel(block, node));
            if meet_pixel_alone(simd, stage, pixel, range, ray) {
                any = true;
                if ray.left[..T::CHANNELS].iter().all(|&left| left < stage.least) {
                    ray.left = [0.0; 3];
                    ray.end = -1.0;
                    return true;
                }
            }
        }
    }
    any
}

/// The fragments of one pixel against one ray, 16 at a time, as
/// [`Lanes::meet`] does for one fragment and 16 rays. Tells whether any was
/// met.
#[inline(always)]
fn meet_pixel_alone<S: Simd, T: Transmittance>(
    simd: S,
    stage: &Stage<'_, T>,
    (pixel, fragments): ([u32; 2], PixelFragments<'_>),
    [enter, leave]: [f32; 2],
    ray: &mut OneRay,
) -> bool {
    let apex = stage.apex;
    let beyond = [apex.place[0] - pixel[0] as f32, apex.place[1] - pixel[1] as f32];
    let from_centre = [beyond[0] - 0.5, beyond[1] - 0.5];
    let splat = |value| f32x16::splat(simd, value);
    let mut any = false;
    let mut first = 0;
    while first < fragments.count {
        let some = fragments.planes(simd, first);
        let [along_x, along_y] = some.gradient;
        let away = some.w - apex.w;
        let reach = (along_x.abs() + along_y.abs()) * 0.502 + some.w.abs() * 2e-6;
        let near = (away + reach).simd_ge(splat(enter));
        let near = near & (away - reach).simd_le(splat(leave));
        if near.to_bitmask() as u32 & some.lanes == 0 {
            first += LANES;
            continue;
        }
        let distance = away + (along_x * from_centre[0] + along_y * from_centre[1]);
        let closing = splat(1.0) - (along_x * ray.slope[0] + along_y * ray.slope[1]);
        let u = distance / closing;
        let x = (u * ray.slope[0] + beyond[0]) * 8.0;
        let y = (u * ray.slope[1] + beyond[1]) * 8.0;
        let (zero, eight) = (splat(0.0), splat(8.0));
        let within = x.simd_ge(zero) & x.simd_lt(eight) & y.simd_ge(zero) & y.simd_lt(eight);
        let earliest = splat(ray.start[0].min(ray.start[1]));
        let met = within & u.simd_ge(earliest) & u.simd_lt(splat(ray.end));
        let mut hits = (met & near).to_bitmask() as u32 & some.lanes;
        if hits != 0 {
            let (u, x, y) = (u.to_array(), x.to_array(), y.to_array());
            let (along_x, along_y) = (along_x.to_array(), along_y.to_array());
            while hits != 0 {
                let lane = hits.trailing_zeros() as usize;
                hits &= hits - 1;
                let at = first + lane;
                let gradient = [along_x[lane], along_y[lane]];
                let bit = ((y[lane] as u32) << 3) | x[lane] as u32;
                let covered = fragments.coverage::<T>(at) >> (bit & 63) & 1 == 1;
                if covered && u[lane] >= ray.start[usize::from(is_facing(gradient))] {
                    any = true;
                    for channel in 0..T::CHANNELS {
                        ray.left[channel] *= 1.0 - fragments.opacity(at, channel);
                    }
                }
            }
        }
        first += LANES;
    }
    any
}

/// The fragments of one pixel for u in `range`. Tells whether any was met.
#[inline(always)]
fn meet_pixel<S: Simd, T: Transmittance>(
    simd: S,
    stage: &Stage<'_, T>,
    (pixel, fragments): ([u32; 2], PixelFragments<'_>),
    [enter, leave]: [f32; 2],
    lanes: &mut Lanes<S>,
) -> bool {
    let apex = stage.apex;
    let beyond = [apex.place[0] - pixel[0] as f32, apex.place[1] - pixel[1] as f32];
    let from_centre = [beyond[0] - 0.5, beyond[1] - 0.5];
    let mut any = false;
    let mut first = 0;
    while first < fragments.count {
        let some = fragments.planes(simd, first);
        let [along_x, along_y] = some.gradient;
        let away = some.w - apex.w;
        let distance = away + (along_x * from_centre[0] + along_y * from_centre[1]);
        let reach = (along_x.abs() + along_y.abs()) * 0.502 + some.w.abs() * 2e-6;
        let near = (away + reach).simd_ge(f32x16::splat(simd, enter));
        let far = (away - reach).simd_le(f32x16::splat(simd, leave));
        let mut hits = (near & far).to_bitmask() as u32 & some.lanes;
        let (distance, along_x, along_y) =
            (distance.to_array(), along_x.to_array(), along_y.to_array());
        while hits != 0 {
            let lane = hits.trailing_zeros() as usize;
            hits &= hits - 1;
            let at = first + lane;
            let gradient = [along_x[lane], along_y[lane]];
            let coverage = fragments.coverage::<T>(at);
            let facing = is_facing(gradient);
            let met = lanes.meet(simd, beyond, distance[lane], gradient, facing, coverage);
            if met.to_bitmask() != 0 {
                lanes.take::<T>(met, |channel| fragments.opacity(at, channel));
                any = true;
            }
        }
        first += LANES;
    }
    any
}

/// The cone of all packets.
pub(crate) fn whole<'a>(packets: impl Iterator<Item = &'a Packet>, apex: &Apex) -> Cone {
    let mut cone = Cone::empty(apex.place, apex.w);
    for packet in packets.filter(|packet| !packet.cone.is_empty()) {
        cone.include(&packet.cone);
    }
    cone
}
