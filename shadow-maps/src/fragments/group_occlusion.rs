//! The occlusion test of a whole group of rays.

use dsm_core::Transmittance;
use fearless_simd::{Simd, SimdBase, SimdMask, f32x16};

use super::apex::Distances;
use super::cone::Cone;
use super::kernel::Stage;
use super::packet::Reach;
use super::range_tree::{Block, bits};

/// Room for rounding, in pixels, and as a share of u.
const ROOM: f32 = 1e-3;
const SHARE: f32 = 1e-5;

/// Chunks that are looked at: what blocks all rays lies next to where they start.
const CHUNKS: usize = 2;

/// True if one fragment of a pixel near the apex takes the light of all rays of
/// `cone`: the surface that the receiver lies on, where it faces away from the light.
///
/// Never where single rays would tell otherwise.
#[inline(always)]
pub(crate) fn is_blocked<S: Simd, T: Transmittance>(
    simd: S,
    stage: &Stage<'_, T>,
    size: [u32; 2],
    cone: &Cone,
    reach: Reach,
) -> bool {
    let apex = stage.apex;
    let inside = |axis: usize| (0.0..size[axis] as f32).contains(&apex.place[axis]);
    if !(inside(0) && inside(1) && reach.starts[0] < reach.end) {
        return false;
    }
    let block = Block { level: 0, at: apex.place.map(|at| at as u32 / 4) };
    let fragments = stage.fragments.block::<T>(block.at);
    let splat = |value| f32x16::splat(simd, value);
    let mut looked = 0;
    for group in 0..fragments.groups() {
        let high = apex.w + cone.far;
        for chunk in bits(fragments.chunks(simd, group, apex.w, high)) {
            if looked == CHUNKS {
                return false;
            }
            looked += 1;
            let chunk = fragments.chunk::<T>(group, chunk);
            let some = chunk.planes(simd);
            let [along_x, along_y] = some.gradient;
            let Distances { beyond: [beyond_x, beyond_y], distance, doubtful, .. } =
                apex.distances(simd, block, &some);
            // Bounds over all slopes.
            let [[x0, x1], [y0, y1]] = cone.slopes;
            let (a, b) = (along_x * x0, along_x * x1);
            let (c, d) = (along_y * y0, along_y * y1);
            let slowest = splat(1.0) - (a.max(b) + c.max(d));
            let fastest = splat(1.0) - (a.min(b) + c.min(d));
            let first = distance / fastest * (1.0 - SHARE);
            let last = distance / slowest * (1.0 + SHARE);
            let times = slowest.simd_gt(splat(SHARE))
                & first.simd_ge(splat(reach.starts[0]))
                & last.simd_lt(splat(reach.end));
            let left = beyond_x + (first * x0).min(last * x0);
            let right = beyond_x + (first * x1).max(last * x1);
            let upper = beyond_y + (first * y0).min(last * y0);
            let lower = beyond_y + (first * y1).max(last * y1);
            let places =
                left.min(upper).simd_gt(splat(ROOM)) & right.max(lower).simd_lt(splat(1.0 - ROOM));
            let candidates = (times & places).to_bitmask() as u32 & some.lanes & !doubtful;
            let first = first.to_array();
            let dark = |at: usize| {
                let start = reach.starts[usize::from(chunk.is_facing(at))];
                let mut channels = (0..T::CHANNELS).map(|channel| chunk.opacity(at, channel));
                first[at] >= start
                    && chunk.coverage::<T>(at) == u64::MAX
                    && channels.all(|opacity| 1.0 - opacity < stage.least)
            };
            if bits(candidates).any(dark) {
                return true;
            }
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use std::marker::PhantomData;

    use dsm_core::Facing;
    use fearless_simd::{Level, dispatch};
    use glam::DVec3;

    use super::super::apex::Apex;
    use super::super::fragment::Fragment;
    use super::super::oracle::{frame, map};
    use super::super::packed::PackedFragments;
    use super::super::packet::{Packet, Starts};
    use super::super::range_tree::RangeTree;
    use super::*;

    /// Whether 16 rays from behind one fragment, the second of a pixel, are told to
    /// be blocked: from this place of the pixel, with these starts, and up to `end`.
    fn blocked(fragment: Fragment<f32>, place: [f64; 2], starts: [f64; 2], end: f32) -> bool {
        let at = |at: i32, step: i32| 0.2 * f64::from(at / step % 4) - 0.3;
        let lights: Vec<_> = (0..16).map(|i| DVec3::new(at(i, 1), at(i, 4), 0.0)).collect();
        blocked_from(&lights, fragment, place, starts, end)
    }

    fn blocked_from(
        lights: &[DVec3],
        fragment: Fragment<f32>,
        place: [f64; 2],
        starts: [f64; 2],
        end: f32,
    ) -> bool {
        let frame = frame([8, 8], 0.0);
        let hole = Fragment { w: 0.21, coverage: 1, ..fragment };
        let mut pixels = vec![Vec::new(); 64];
        pixels[8 * 5 + 2] = vec![hole, fragment];
        let map = map(frame, &pixels);
        let fragments = PackedFragments::new(&map).unwrap();
        let mut tree = RangeTree::new([8, 8]);
        fragments.for_each::<f32>(|pixel, some| tree.include(pixel, some.range()));
        let receiver = frame.unproject(2.0 + place[0], 5.0 + place[1], 5.0);
        let apex = Apex::new(&frame, receiver, Facing::Light).unwrap().without_surface();
        let (tree, fragments, value) = (&tree, &fragments, PhantomData::<f32>);
        let stage = Stage { fragments, value, tree, apex: &apex, least: 1e-3 };
        dispatch!(Level::new(), simd => {
            let starts = Starts::Distances(starts);
            let packet = Packet::new(simd, &frame, &apex, lights, starts, [0.2, 0.9]);
            let all = Reach { starts: [0.0; 2], end };
            is_blocked(simd, &stage, [8, 8], &packet.cone, packet.reach.and(all))
        })
    }

    #[test]
    fn only_a_whole_opaque_fragment_before_all_rays_blocks_them() {
        let coverage = Fragment::<f32>::WHOLE;
        let wall = Fragment { w: 0.25, gradient: Some([0.01, -0.01]), opacity: 1.0, coverage };
        let middle = [0.5, 0.5];
        let early = [5e-4; 2];
        assert!(blocked(wall, middle, early, 1.0));
        assert!(!blocked(wall, [0.02, 0.5], early, 1.0), "some pass beside it");
        assert!(!blocked(wall, [0.5, 0.99], early, 1.0), "some pass below it");
        assert!(!blocked(Fragment { coverage: !(1 << 50), ..wall }, middle, early, 1.0));
        assert!(!blocked(Fragment { opacity: 0.9, ..wall }, middle, early, 1.0));
        assert!(blocked(Fragment { opacity: 0.9995, ..wall }, middle, early, 1.0), "nearly");
        assert!(!blocked(wall, middle, early, 0.04), "it lies beyond the end");
        assert!(!blocked(wall, middle, [2.5; 2], 1.0), "it lies before the start");
        // A light behind the receiver is seen.
        let lights = [DVec3::ZERO, DVec3::new(0.0, 0.0, -6.0)];
        assert!(blocked_from(&lights[..1], wall, middle, early, 1.0));
        assert!(!blocked_from(&lights, wall, middle, early, 1.0));
        // What faces the camera counts later than planes.
        let late = [5e-4, 2.5];
        let facing = Fragment { gradient: None, ..wall };
        assert!(blocked(wall, middle, late, 1.0) && !blocked(facing, middle, late, 1.0));
        assert!(blocked(facing, middle, early, 1.0));
    }
}
