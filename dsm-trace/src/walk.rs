//! Traversal of the pixels that a shadow ray crosses (Xie et al. 2007, §4.3).

use std::ops::ControlFlow;

use super::min_max_pyramid::MinMaxPyramid;
use super::shadow_ray::ShadowRay;

/// A visitor of the pixels that a ray crosses. Any function of the pixel and the w
/// = 1/depth where the ray enters and leaves it is one.
pub trait PixelLeaf {
    /// The ray is within `pixel` for w in [`enter`, `leave`), further along it
    /// than at the pixel before. [`ControlFlow::Break`] ends the walk.
    fn meet(&mut self, pixel: [u32; 2], enter: f64, leave: f64) -> ControlFlow<()>;
}

impl<F: FnMut([u32; 2], f64, f64) -> ControlFlow<()>> PixelLeaf for F {
    fn meet(&mut self, pixel: [u32; 2], enter: f64, leave: f64) -> ControlFlow<()> {
        self(pixel, enter, leave)
    }
}

/// Walks a clipped ray ([`ShadowRay::clip`]) from the receiver towards the
/// light, through the pixels whose layers it may meet: w ranges of nodes and
/// pixels that the ray's does not touch are skipped. Those that it touches in
/// one point are not. O(log pixels) for each pixel that is met, and for
/// each stretch that is skipped.
///
/// ```
/// use std::ops::ControlFlow;
/// use dsm_trace::{MinMaxPyramid, ShadowRay, walk_pixels};
///
/// // One layer, of depth 2, in the left half of the map.
/// let pyramid = MinMaxPyramid::new([8, 8], |x, _| (x < 4).then_some([0.5, 0.5]))?;
/// let ray = ShadowRay::new([1.5, 2.5], 0.25, [2.0, 0.0], 1.0);
/// let ray = ray.clip([8, 8], [0.5, 0.5]).ray.unwrap();
/// let mut met = Vec::new();
/// let _ = walk_pixels(&pyramid, &ray, &mut |pixel, _: f64, _: f64| {
///     met.push(pixel);
///     ControlFlow::Continue(())
/// });
/// assert_eq!(met, [[2, 2]]);
/// # Ok::<(), dsm_core::Error>(())
/// ```
pub fn walk_pixels(
    pyramid: &MinMaxPyramid,
    ray: &ShadowRay,
    leaf: &mut impl PixelLeaf,
) -> ControlFlow<()> {
    if !ray.is_sound() {
        return ControlFlow::Continue(());
    }
    // The nearer column and row of each four.
    let near = ray.slope().map(|slope| u32::from(slope < 0.0));
    visit(pyramid, ray, near, pyramid.level_count() - 1, [0; 2], leaf)
}

fn visit(
    pyramid: &MinMaxPyramid,
    ray: &ShadowRay,
    near: [u32; 2],
    level: usize,
    node: [u32; 2],
    leaf: &mut impl PixelLeaf,
) -> ControlFlow<()> {
    let size = pyramid.size();
    let min = node.map(|at| at << level);
    let max = [0, 1].map(|axis| (min[axis] + (1 << level)).min(size[axis]));
    let Some(crossing) = ray.crossing(min, max) else { return ControlFlow::Continue(()) };
    if !pyramid.overlaps(level, node[0], node[1], crossing) {
        return ControlFlow::Continue(());
    }
    if level == 0 {
        return leaf.meet(node, crossing[0], crossing[1]);
    }
    // A line crosses one of the two in the middle at most.
    for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let below = [2 * node[0] + (near[0] ^ dx), 2 * node[1] + (near[1] ^ dy)];
        visit(pyramid, ray, near, level - 1, below, leaf)?;
    }
    ControlFlow::Continue(())
}

/// Walks a clipped ray through every pixel of a map of `size` that it crosses, and
/// tests the borders of all: the oracle of [`walk_pixels`]. Visits all, whatever
/// the leaf answers. O(width · height).
pub fn walk_every_pixel(size: [u32; 2], ray: &ShadowRay, leaf: &mut impl PixelLeaf) {
    let mut crossed = Vec::new();
    if !ray.is_sound() {
        return;
    }
    for y in 0..size[1] {
        for x in 0..size[0] {
            let crossing = ray.crossing([x, y], [x + 1, y + 1]);
            crossed.extend(crossing.map(|crossing| ([x, y], crossing)));
        }
    }
    crossed.sort_by(|(_, a), (_, b)| a[0].total_cmp(&b[0]));
    for (pixel, [enter, leave]) in crossed {
        let _ = leaf.meet(pixel, enter, leave);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    pub(crate) fn config(seed: u64) -> ProptestConfig {
        let long = std::env::var_os("DSM_LONG_TESTS").is_some_and(|value| value == "1");
        ProptestConfig {
            cases: if long { 20_000 } else { 256 },
            rng_seed: RngSeed::Fixed(seed),
            failure_persistence: None,
            ..ProptestConfig::default()
        }
    }

    /// Halves, so that rays run along borders and through corners.
    fn half() -> impl Strategy<Value = f64> {
        (-4_i8..36).prop_map(|value| f64::from(value) / 2.0)
    }

    type Layer = Option<[f32; 2]>;

    fn map() -> impl Strategy<Value = ([u32; 2], Vec<Layer>)> {
        let layer = proptest::option::of((0_u8..9, 0_u8..3)).prop_map(|layer| {
            layer.map(|(low, more)| [low, low + more].map(|at| f32::from(at) / 4.0))
        });
        (1_u32..17, 1_u32..17).prop_flat_map(move |(width, height)| {
            let count = (width * height) as usize;
            (Just([width, height]), proptest::collection::vec(layer.clone(), count))
        })
    }

    proptest! {
        #![proptest_config(config(11))]

        #[test]
        fn every_pixel_that_may_be_met_is((size, layers) in map(), place in [half(), half()],
            slope in [half(), half()], turn in [any::<bool>(), any::<bool>()],
            (start, length) in (0_u8..5, 1_u8..9), stop in 0_usize..8)
        {
            let slope = [0, 1].map(|axis| {
                (if turn[axis] { -1.0 } else { 1.0 }) * (slope[axis] * 4.0)
            });
            let start = f64::from(start) / 4.0;
            let ray = ShadowRay::new(place, start, slope, start + f64::from(length) / 4.0);
            let layer = |x: u32, y: u32| layers[(y * size[0] + x) as usize];
            let pyramid = MinMaxPyramid::new(size, layer).unwrap();
            let clip = pyramid.range().map(|range| ray.clip(size, range));
            let mut expected = Vec::new();
            if let Some(ray) = clip.and_then(|clip| clip.ray) {
                walk_every_pixel(size, &ray, &mut |pixel: [u32; 2], enter: f64, leave: f64| {
                    let within = |[low, high]: [f32; 2]| {
                        f64::from(low) <= leave && enter <= f64::from(high)
                    };
                    if layer(pixel[0], pixel[1]).is_some_and(within) {
                        expected.push((pixel, enter, leave));
                    }
                    ControlFlow::Break(())
                });
                let mut met = Vec::new();
                let ended = walk_pixels(&pyramid, &ray, &mut |pixel, enter: f64, leave: f64| {
                    met.push((pixel, enter, leave));
                    if met.len() == stop { ControlFlow::Break(()) } else {
                        ControlFlow::Continue(())
                    }
                });
                prop_assert_eq!(ended.is_break(), stop > 0 && expected.len() >= stop);
                if stop > 0 {
                    expected.truncate(stop);
                }
                prop_assert_eq!(met, expected);
            }
            // The clip loses nothing that the whole ray meets within the map's depths.
            let mut whole = Vec::new();
            walk_every_pixel(size, &ray, &mut |[x, y]: [u32; 2], enter: f64, leave: f64| {
                let met = |w: f32| f64::from(w) >= enter && f64::from(w) < leave;
                whole.extend(layer(x, y).filter(|range| met(range[0])).map(|_| [x, y]));
                ControlFlow::Continue(())
            });
            let mut clipped = Vec::new();
            if let Some(ray) = clip.and_then(|clip| clip.ray) {
                let _ = walk_pixels(&pyramid, &ray, &mut |[x, y]: [u32; 2], enter: f64, leave| {
                    let met = |w: f32| f64::from(w) >= enter && f64::from(w) < leave;
                    clipped.extend(layer(x, y).filter(|range| met(range[0])).map(|_| [x, y]));
                    ControlFlow::Continue(())
                });
            }
            prop_assert_eq!(clipped, whole);
        }
    }

    #[test]
    fn a_ray_that_is_no_ray_meets_nothing() {
        let pyramid = MinMaxPyramid::new([4, 4], |_, _| Some([0.0, 1.0])).unwrap();
        let ray = ShadowRay::new([f64::NAN, 1.0], 0.0, [1.0, 1.0], 1.0);
        let mut count = 0;
        let mut leaf = |_: [u32; 2], _: f64, _: f64| {
            count += 1;
            ControlFlow::Continue(())
        };
        let _ = walk_pixels(&pyramid, &ray, &mut leaf);
        walk_every_pixel([4, 4], &ray, &mut leaf);
        assert_eq!(count, 0);
    }
}
