//! Linear motion of corners while the shutter is open.

use fearless_simd::{Simd, SimdBase, f32x16};
use glam::{DVec2, DVec3};

use super::cells::RayLanes;
use super::fused::fused;
use super::rays::Rays;

/// A corner of a primitive in ray space.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Corner {
    pub(super) place: [f32; 2],
    /// The factor of a ray at this depth: the depth in ray space, or 1 where rays
    /// are parallel.
    pub(super) factor: f32,
    /// Depth in camera space.
    pub(super) depth: f32,
    pub(super) radius: f32,
}

impl Corner {
    /// The corner at a point in camera space.
    pub(super) fn new(rays: &Rays, point: DVec3, radius: f32) -> Self {
        let point = rays.point(point);
        Self {
            place: [point.x as f32, point.y as f32],
            factor: if rays.is_perspective() { point.z as f32 } else { 1.0 },
            depth: (point.z + rays.depth_offset()) as f32,
            radius,
        }
    }

    /// The point in ray space.
    pub(super) fn point(&self, rays: &Rays) -> DVec3 {
        let [x, y] = self.place.map(f64::from);
        let perspective = rays.is_perspective();
        DVec3::new(x, y, if perspective { self.factor } else { self.depth }.into())
    }

    /// The point in camera space, up to a shift that all points share.
    pub(super) fn camera_point(&self, rays: &Rays) -> DVec3 {
        let [x, y] = self.place.map(f64::from);
        let depth = f64::from(self.depth);
        let across = DVec2::new(x, y) + rays.shear() * depth;
        across.extend(-depth)
    }

    pub(super) fn is_finite(&self) -> bool {
        let Self { place: [x, y], factor, depth, radius } = *self;
        [x, y, factor, depth, radius].iter().all(|number| number.is_finite())
    }
}

/// A corner as the lanes see it.
#[derive(Clone, Copy)]
pub(super) struct SeenCorner<S: Simd> {
    /// Relative to the ray through the middle of the cell, where its factor is
    /// this corner's.
    pub(super) place: [f32x16<S>; 2],
    pub(super) factor: f32x16<S>,
    pub(super) depth: f32x16<S>,
    pub(super) radius: f32x16<S>,
}

// Plain functions and no closures, here and where vectors are computed with:
// what is not inlined into the level's code runs without its instructions.
impl<S: Simd> SeenCorner<S> {
    /// The corner at the times of the lanes, from where the shutter opens to
    /// where it closes, if it `MOVES`.
    #[inline(always)]
    pub(super) fn new<const MOVES: bool>(
        simd: S,
        open: &Corner,
        close: &Corner,
        lanes: &RayLanes<S>,
    ) -> Self {
        let open = Self::still(simd, open, lanes);
        if !MOVES {
            return open;
        }
        let close = Self::still(simd, close, lanes);
        let time = lanes.time;
        Self {
            place: [
                between(open.place[0], close.place[0], time),
                between(open.place[1], close.place[1], time),
            ],
            factor: between(open.factor, close.factor, time),
            depth: between(open.depth, close.depth, time),
            radius: between(open.radius, close.radius, time),
        }
    }

    #[inline(always)]
    fn still(simd: S, corner: &Corner, lanes: &RayLanes<S>) -> Self {
        let factor = f32x16::splat(simd, corner.factor);
        let [x, y] = corner.place;
        // Rounded once, however far the camera: what is left is as small as the
        // cell and the primitive.
        Self {
            place: [
                fused(-lanes.centre[0], factor, f32x16::splat(simd, x)),
                fused(-lanes.centre[1], factor, f32x16::splat(simd, y)),
            ],
            factor,
            depth: f32x16::splat(simd, corner.depth),
            radius: f32x16::splat(simd, corner.radius),
        }
    }

    /// The vectors from each ray to the corner, in its plane of constant depth.
    #[inline(always)]
    pub(super) fn beyond_rays(&self, lanes: &RayLanes<S>) -> [f32x16<S>; 2] {
        [
            fused(-lanes.ray[0], self.factor, self.place[0]),
            fused(-lanes.ray[1], self.factor, self.place[1]),
        ]
    }

    /// This corner less another.
    #[inline(always)]
    pub(super) fn less(&self, other: &Self) -> Self {
        Self {
            place: [self.place[0] - other.place[0], self.place[1] - other.place[1]],
            factor: self.factor - other.factor,
            depth: self.depth - other.depth,
            radius: self.radius - other.radius,
        }
    }
}

#[inline(always)]
fn between<S: Simd>(open: f32x16<S>, close: f32x16<S>, time: f32x16<S>) -> f32x16<S> {
    fused(close - open, time, open)
}

/// a · b
#[inline(always)]
pub(super) fn dot<S: Simd>(a: [f32x16<S>; 2], b: [f32x16<S>; 2]) -> f32x16<S> {
    fused(a[0], b[0], a[1] * b[1])
}
