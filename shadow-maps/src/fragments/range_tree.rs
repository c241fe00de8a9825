//! Where in a map a group of rays may meet something: a tree with 16 children a
//! node, which are tested at once.

use fearless_simd::{Simd, SimdBase, SimdMask, f32x16};

use super::cone::Cone;
use super::lane_count::LANES;
use super::lanes::Lanes;
use super::large_pages::LargePages;

/// Children along the side of a node.
const SIDE: u32 = 4;

/// Room for rounding, in pixels.
const SLACK: f32 = 1.0 / 256.0;

/// The least and the greatest w of the pixels of a map, of 4 × 4 pixels, of
/// 16 × 16 and so on, up to one block.
#[derive(Debug)]
pub(crate) struct RangeTree {
    levels: Vec<TreeLevel>,
}

/// Nodes of 4ⁿ pixels along the side, in blocks of 4 × 4.
#[derive(Debug)]
struct TreeLevel {
    /// In blocks.
    size: [u32; 2],
    /// The least w of each node, and the greatest, which is above 0; of an empty node both
    /// are 0, so that no memory is written for it.
    ranges: LargePages<[[f32; LANES]; 2]>,
}

/// A block of 16 nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Block {
    pub(crate) level: u32,
    pub(crate) at: [u32; 2],
}

/// The children of a block that a cone may meet, and over which u.
pub(crate) struct Overlap {
    pub(crate) lanes: u32,
    pub(crate) enter: [f32; LANES],
    pub(crate) leave: [f32; LANES],
}

/// 1 / slope of one side of a cone, and what to add to a bound of u that comes
/// from it to make it one from below, or from above: 0 or an infinity.
type SlopeBound<S> = (f32x16<S>, f32x16<S>, f32x16<S>);

/// A cone, ready for tests.
#[derive(Clone, Copy)]
pub(crate) struct ConeTest<S: Simd> {
    place: [f32; 2],
    w: f32x16<S>,
    near: f32x16<S>,
    far: f32x16<S>,
    /// Of each axis, the least slope first.
    bounds: [[SlopeBound<S>; 2]; 2],
    columns: f32x16<S>,
    rows: f32x16<S>,
}

impl<S: Simd> ConeTest<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, cone: &Cone) -> Self {
        let splat = |value| f32x16::splat(simd, value);
        let least = cone.least_slope();
        let bound = |slope: f32, greatest: bool| {
            // Wider by more than all rounding, and never 0.
            let widen = 1e-5 * slope.abs() + least;
            let slope = if greatest { slope + widen } else { slope - widen };
            let slope = if slope == 0.0 { least } else { slope };
            let from_below = (slope > 0.0) == greatest;
            let infinity = f32::INFINITY;
            let (low, high) = if from_below { (0.0, infinity) } else { (-infinity, 0.0) };
            (splat(slope.recip()), splat(low), splat(high))
        };
        let slack = cone.slack();
        let mut columns = [0.0; LANES];
        let mut rows = [0.0; LANES];
        for lane in 0..LANES {
            columns[lane] = (lane % 4) as f32;
            rows[lane] = (lane / 4) as f32;
        }
        Self {
            place: cone.place,
            w: splat(cone.w),
            near: splat(cone.near - slack),
            far: splat(cone.far + slack),
            bounds: [
                [bound(cone.slopes[0][0], false), bound(cone.slopes[0][1], true)],
                [bound(cone.slopes[1][0], false), bound(cone.slopes[1][1], true)],
            ],
            columns: f32x16::load_array(simd, columns),
            rows: f32x16::load_array(simd, rows),
        }
    }

    /// The u where the cone may be in pixels that begin `first` pixels from its
    /// place, of `range` each. Nowhere if the second is less than the first.
    #[inline(always)]
    pub(crate) fn in_pixels(
        &self,
        first: [f32x16<S>; 2],
        range: [f32x16<S>; 2],
    ) -> (f32x16<S>, f32x16<S>) {
        let range = (range[0].max(self.near), range[1].min(self.far));
        let range = self.narrow(0, first[0], 1.0, range);
        self.narrow(1, first[1], 1.0, range)
    }

    /// Narrows [`enter`, `leave`] to where the cone is over nodes of `side`
    /// pixels that begin `first` pixels from its place along an axis.
    #[inline(always)]
    fn narrow(
        &self,
        axis: usize,
        first: f32x16<S>,
        side: f32,
        range: (f32x16<S>, f32x16<S>),
    ) -> (f32x16<S>, f32x16<S>) {
        let [(least, least_low, least_high), (most, most_low, most_high)] = self.bounds[axis];
        // The greatest slope must reach the near side, the least one not pass the far one.
        let reach = (first - SLACK) * most;
        let pass = (first + (side + SLACK)) * least;
        let enter = range.0.max(reach + most_low).max(pass + least_low);
        let leave = range.1.min(reach + most_high).min(pass + least_high);
        (enter, leave)
    }
}

/// One ray, ready for tests.
#[derive(Clone, Copy)]
pub(crate) struct RayTest<S: Simd> {
    place: [f32; 2],
    w: f32,
    near: f32,
    far: f32,
    inverse: [f32; 2],
    columns: f32x16<S>,
    rows: f32x16<S>,
}

impl<S: Simd> RayTest<S> {
    /// The ray from `place` and `w` with these slopes, for u in
    /// [`near`, `far`].
    #[inline(always)]
    pub(crate) fn new(cone: &ConeTest<S>, inverse: [f32; 2], near: f32, far: f32, w: f32) -> Self {
        let ConeTest { place, columns, rows, .. } = *cone;
        Self { place, w, near, far, inverse, columns, rows }
    }
}

/// The numbers of the bits that are set.
#[inline(always)]
pub(crate) fn bits(mut set: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let bit = (set != 0).then(|| set.trailing_zeros() as usize);
        set &= set.wrapping_sub(1);
        bit
    })
}

impl RangeTree {
    /// Of a map of `size` empty pixels.
    pub(crate) fn new(size: [u32; 2]) -> Self {
        let mut levels = vec![TreeLevel::new(size)];
        while let Some(below) = levels.last().filter(|level| level.size[0].max(level.size[1]) > 1) {
            levels.push(TreeLevel::new(below.size));
        }
        Self { levels }
    }

    /// Takes in the range of something in a pixel of the map.
    pub(crate) fn include(&mut self, mut node: [u32; 2], [least, most]: [f32; 2]) {
        let most = most.max(f32::MIN_POSITIVE);
        for level in &mut self.levels {
            let [x, y] = node;
            let block = (y / SIDE * level.size[0] + x / SIDE) as usize;
            let lane = (y % SIDE * SIDE + x % SIDE) as usize;
            let [low, high] = &mut level.ranges[block];
            let (low, high) = (&mut low[lane], &mut high[lane]);
            if *high == 0.0 {
                (*low, *high) = (least, most);
            } else if *low <= least && most <= *high {
                // And so do the nodes above.
                return;
            } else {
                (*low, *high) = (low.min(least), high.max(most));
            }
            node = node.map(|at| at / SIDE);
        }
    }

    /// The block of the highest level.
    pub(crate) fn root(&self) -> Block {
        // A map has 2²⁴ pixels a side at most: 12 levels.
        Block { level: (self.levels.len() - 1) as u32, at: [0; 2] }
    }

    /// The least and the greatest w of the map; `None` for an empty one.
    pub(crate) fn range(&self) -> Option<[f32; 2]> {
        let top = self.levels.last()?;
        whole(top.ranges.first()?)
    }

    /// The nodes of `block` that the cone may meet.
    #[inline(always)]
    pub(crate) fn overlap<S: Simd>(&self, simd: S, block: Block, cone: &ConeTest<S>) -> Overlap {
        let level = &self.levels[block.level as usize];
        let index = block.at[1] as usize * level.size[0] as usize + block.at[0] as usize;
        let side = (1_u32 << (2 * block.level)) as f32;
        let first =
            [0, 1].map(|axis| (block.at[axis] as f32 * 4.0).mul_add(side, -cone.place[axis]));
        let [low, high] = &level.ranges[index];
        let low = f32x16::load_array_ref(simd, low) - cone.w;
        let high = f32x16::load_array_ref(simd, high) - cone.w;
        let range = (low.max(cone.near), high.min(cone.far));
        let columns = cone.columns * side + first[0];
        let rows = cone.rows * side + first[1];
        let range = cone.narrow(0, columns, side, range);
        let (enter, leave) = cone.narrow(1, rows, side, range);
        let lanes = enter.simd_le(leave).to_bitmask() as u32;
        Overlap { lanes, enter: enter.to_array(), leave: leave.to_array() }
    }

    /// The nodes of `block` that one ray may meet.
    #[inline(always)]
    pub(crate) fn overlap_ray<S: Simd>(&self, simd: S, block: Block, ray: &RayTest<S>) -> Overlap {
        let level = &self.levels[block.level as usize];
        let index = block.at[1] as usize * level.size[0] as usize + block.at[0] as usize;
        let side = (1_u32 << (2 * block.level)) as f32;
        let [low, high] = &level.ranges[index];
        let low = f32x16::load_array_ref(simd, low) - ray.w;
        let high = f32x16::load_array_ref(simd, high) - ray.w;
        let mut enter = low.max(f32x16::splat(simd, ray.near));
        let mut leave = high.min(f32x16::splat(simd, ray.far));
        for (axis, offsets) in [ray.columns, ray.rows].into_iter().enumerate() {
            let first = (block.at[axis] as f32 * 4.0).mul_add(side, -ray.place[axis]);
            let inverse = ray.inverse[axis];
            // Where the ray passes the nearer and the farther side of a node.
            let (near, far) = if inverse > 0.0 {
                (first - SLACK, first + side + SLACK)
            } else {
                (first + side + SLACK, first - SLACK)
            };
            let step = side * inverse;
            enter = enter.max(offsets * step + near * inverse);
            leave = leave.min(offsets * step + far * inverse);
        }
        let lanes = enter.simd_le(leave).to_bitmask() as u32;
        Overlap { lanes, enter: enter.to_array(), leave: leave.to_array() }
    }

    /// Which of 16 rays from `place` and `w` may meet node `lane` of `block`.
    #[inline(always)]
    pub(crate) fn rays_over<S: Simd>(
        &self,
        simd: S,
        block: Block,
        lane: u32,
        place: [f32; 2],
        w: f32,
        rays: &Lanes,
    ) -> u32 {
        let level = &self.levels[block.level as usize];
        let index = block.at[1] as usize * level.size[0] as usize + block.at[0] as usize;
        let side = (1_u32 << (2 * block.level)) as f32;
        let [low, high] = level.ranges[index].map(|bounds| bounds[lane as usize] - w);
        let load = |column: &[f32; LANES]| f32x16::load_array_ref(simd, column);
        let mut enter = load(&rays.near).max(f32x16::splat(simd, low));
        let mut leave = load(&rays.far).min(f32x16::splat(simd, high));
        let node = [block.at[0] * 4 + lane % 4, block.at[1] * 4 + lane / 4];
        for axis in 0..2 {
            let first = (node[axis] as f32).mul_add(side, -place[axis]);
            let inverse = load(&rays.inverse[axis]);
            let one = inverse * (first - SLACK);
            let other = inverse * (first + side + SLACK);
            enter = enter.max(one.min(other));
            leave = leave.min(one.max(other));
        }
        enter.simd_le(leave).to_bitmask() as u32
    }

    /// The block of the children of node `lane` of `block`.
    #[inline(always)]
    pub(crate) fn below(block: Block, lane: u32) -> Block {
        let [x, y] = block.at;
        let at = [4 * x + lane % 4, 4 * y + lane / 4];
        Block { level: block.level.saturating_sub(1), at }
    }
}

/// The range of all nodes of a block; `None` if there are none.
fn whole([low, high]: &[[f32; LANES]; 2]) -> Option<[f32; 2]> {
    let nodes = low.iter().zip(high).filter(|&(_, &high)| high > 0.0);
    nodes.map(|(&low, &high)| [low, high]).reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
}

impl TreeLevel {
    fn new(nodes: [u32; 2]) -> Self {
        let size = nodes.map(|side| side.div_ceil(SIDE).max(1));
        Self { size, ranges: LargePages::zeroed(size[0] as usize * size[1] as usize) }
    }
}
