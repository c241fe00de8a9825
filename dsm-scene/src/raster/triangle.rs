//! Triangles.

use fearless_simd::{Simd, SimdBase, f32x16, mask32x16};
use glam::{DVec3, Vec3};

use super::cells::RayLanes;
use super::corner::{Corner, SeenCorner};
use super::fused::fused;
use super::outline::Outline;
use super::primitive::Primitive;
use super::rays::Rays;

/// A triangle in ray space, at one or two times. A ray through an edge that two
/// triangles share meets one of them.
#[derive(Clone, Copy, Debug)]
pub(super) struct RayTriangle<const KEYS: usize> {
    corners: [[Corner; 3]; KEYS],
}

impl<const KEYS: usize> RayTriangle<KEYS> {
    /// The triangle between corners in camera space.
    pub(super) fn new(rays: &Rays, keys: [[DVec3; 3]; KEYS]) -> Self {
        let corners = |triangle: [DVec3; 3]| triangle.map(|point| Corner::new(rays, point, 0.0));
        Self { corners: keys.map(corners) }
    }
}

impl<const KEYS: usize> Primitive for RayTriangle<KEYS> {
    type Outline = Outline<KEYS, 3>;

    const HAS_NORMAL: bool = true;
    const TURNS: bool = false;
    const MOVES: bool = KEYS > 1;

    fn outline(&self, rays: &Rays) -> Option<Self::Outline> {
        Outline::project(rays, &self.corners)
    }

    fn normal(&self, rays: &Rays, time: f32, _: DVec3) -> Option<Vec3> {
        let (open, close) = (&self.corners[0], &self.corners[KEYS - 1]);
        let [a, b, c] = [0, 1, 2].map(|at| {
            let [open, close] = [open, close].map(|key| key[at].camera_point(rays));
            open.lerp(close, time.into())
        });
        (b - a).cross(c - a).try_normalize().map(|normal| normal.as_vec3())
    }

    fn corners(&self) -> &[Corner] {
        self.corners.as_flattened()
    }

    #[inline(always)]
    fn meet<S: Simd>(&self, simd: S, lanes: &RayLanes<S>) -> (mask32x16<S>, f32x16<S>) {
        let [a, b, c] = {
            let (open, close) = (&self.corners[0], &self.corners[KEYS - 1]);
            if KEYS == 1 {
                [
                    SeenCorner::new::<false>(simd, &open[0], &open[0], lanes),
                    SeenCorner::new::<false>(simd, &open[1], &open[1], lanes),
                    SeenCorner::new::<false>(simd, &open[2], &open[2], lanes),
                ]
            } else {
                [
                    SeenCorner::new::<true>(simd, &open[0], &close[0], lanes),
                    SeenCorner::new::<true>(simd, &open[1], &close[1], lanes),
                    SeenCorner::new::<true>(simd, &open[2], &close[2], lanes),
                ]
            }
        };
        let (to_a, to_b, to_c) = (a.beyond_rays(lanes), b.beyond_rays(lanes), c.beyond_rays(lanes));
        let (of_a, left_of_a) = beside(simd, to_b, to_c);
        let (of_b, left_of_b) = beside(simd, to_c, to_a);
        let (of_c, left_of_c) = beside(simd, to_a, to_b);
        let inside = left_of_a & left_of_b & left_of_c;
        let turned = !(left_of_a | left_of_b | left_of_c);
        let sum = of_a + of_b + of_c;
        let weighted = fused(of_a, a.depth, fused(of_b, b.depth, of_c * c.depth));
        let flat = sum.simd_eq(f32x16::splat(simd, 0.0));
        ((inside | turned) & !flat, weighted / sum)
    }
}

/// Twice the area between the ray and an edge, and on which side the ray passes
/// it. The other way round, both are exactly the opposite.
#[inline(always)]
fn beside<S: Simd>(simd: S, from: [f32x16<S>; 2], to: [f32x16<S>; 2]) -> (f32x16<S>, mask32x16<S>) {
    let zero = f32x16::splat(simd, 0.0);
    // Without fused steps, which would round the two ways differently.
    let area = from[0] * to[1] - from[1] * to[0];
    // A ray through the edge itself passes it on the side where it falls, or
    // goes right.
    let (across, down) = (to[0] - from[0], to[1] - from[1]);
    let owned = down.simd_gt(zero) | (down.simd_eq(zero) & across.simd_gt(zero));
    (area, area.simd_gt(zero) | (area.simd_eq(zero) & owned))
}
