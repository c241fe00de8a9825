//! Segments of strands.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, f32x16, mask32x16};
use glam::{DVec3, Vec3};

use super::cells::RayLanes;
use super::corner::{Corner, SeenCorner, dot};
use super::fused::fused;
use super::outline::Outline;
use super::primitive::Primitive;
use super::rays::Rays;

/// A piece of a strand: a ribbon that faces the ray.
///
/// The ray meets it where it passes the line between the two ends within the
/// radius, interpolated at the point of closest approach: once, at the depth of
/// the ray there. Segments of radius 0 are never met. One that is joined to another
/// is not met where the strand was within its radius before: a strand is met once a
/// crossing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Segment {
    /// Both ends, in camera space: right-handed, the camera looks down −z.
    pub ends: [Vec3; 2],
    /// The radius at either end, ≥ 0, in scene units.
    pub radii: [f32; 2],
    /// True if another segment of the strand ends where this one begins.
    pub is_joined: bool,
}

impl Segment {
    /// Its ends and their radii.
    pub(super) fn corners(&self) -> [(DVec3, f32); 2] {
        [0, 1].map(|end| (self.ends[end].as_dvec3(), self.radii[end]))
    }
}

/// A segment in ray space, at one or two times.
#[derive(Clone, Copy, Debug)]
pub(super) struct RaySegment<const KEYS: usize> {
    ends: [[Corner; 2]; KEYS],
    /// From end to end: more exact than the difference of rounded ends.
    along: [Vec3; KEYS],
    is_joined: bool,
}

impl<const KEYS: usize> RaySegment<KEYS> {
    /// The segment between points in camera space, with their radii.
    pub(super) fn new(rays: &Rays, keys: [[(DVec3, f32); 2]; KEYS], is_joined: bool) -> Self {
        let corner = |(point, radius)| Corner::new(rays, point, radius);
        let along = keys.map(|[(start, _), (end, _)]| (end - start).as_vec3());
        Self { ends: keys.map(|ends| ends.map(corner)), along, is_joined }
    }
}

impl<const KEYS: usize> Primitive for RaySegment<KEYS> {
    type Outline = Outline<KEYS, 2>;

    const HAS_NORMAL: bool = true;
    const TURNS: bool = true;
    const MOVES: bool = KEYS > 1;

    fn outline(&self, rays: &Rays) -> Option<Self::Outline> {
        let ends = self.ends.as_flattened();
        let thick = ends.iter().any(|end| end.radius > 0.0);
        let sound = ends.iter().all(|end| end.radius >= 0.0);
        if thick && sound { Outline::project(rays, &self.ends) } else { None }
    }

    /// That of the ribbon which faces the ray.
    fn normal(&self, _: &Rays, time: f32, ray: DVec3) -> Option<Vec3> {
        let [open, close] = [self.along[0], self.along[KEYS - 1]].map(Vec3::as_dvec3);
        let along = open.lerp(close, time.into()).try_normalize()?;
        (ray - along * ray.dot(along)).try_normalize().map(|normal| normal.as_vec3())
    }

    fn corners(&self) -> &[Corner] {
        self.ends.as_flattened()
    }

    #[inline(always)]
    fn meet<S: Simd>(&self, simd: S, lanes: &RayLanes<S>) -> (mask32x16<S>, f32x16<S>) {
        let zero = f32x16::splat(simd, 0.0);
        let one = f32x16::splat(simd, 1.0);
        let (open, close) = (&self.ends[0], &self.ends[KEYS - 1]);
        let (start, end) = if KEYS == 1 {
            (
                SeenCorner::new::<false>(simd, &open[0], &open[0], lanes),
                SeenCorner::new::<false>(simd, &open[1], &open[1], lanes),
            )
        } else {
            (
                SeenCorner::new::<true>(simd, &open[0], &close[0], lanes),
                SeenCorner::new::<true>(simd, &open[1], &close[1], lanes),
            )
        };
        // In the plane of constant depth through the first end: from the ray to
        // it; and how that changes towards the second end.
        let change = end.less(&start);
        let first = start.beyond_rays(lanes);
        let along = change.beyond_rays(lanes);
        // Of a vector in that plane, ⟨a, b⟩ = a·b − (a·d)(b·d)/|d|² is what
        // remains of a·b across the ray d.
        let first_along = dot(first, lanes.slope);
        let along_along = dot(along, lanes.slope);
        let shrunk = along_along * lanes.shrink;
        let product = fused(-first_along, shrunk, dot(first, along));
        let length = fused(-along_along, shrunk, dot(along, along));
        let approach = -product / length;
        // NaN, of a segment along the ray, is its first end.
        let approach = approach.simd_gt(zero).select(approach, zero);
        let nearest = approach.simd_lt(one).select(approach, one);
        let from_ray = [fused(along[0], nearest, first[0]), fused(along[1], nearest, first[1])];
        let sideways = fused(along_along, nearest, first_along);
        let shift = sideways * lanes.shrink;
        let square = fused(-sideways, shift, dot(from_ray, from_ray));
        let radius = fused(change.radius, nearest, start.radius);
        let depth = fused(change.depth, nearest, start.depth) + shift;
        // The next segment asks the same of its first end, with the same numbers:
        // rounding must not lose a crossing between them.
        let last = end.beyond_rays(lanes);
        let goes_on = within(last, dot(last, lanes.slope), end.radius, lanes);
        let mut meets = square.simd_lt(radius * radius) | goes_on;
        if self.is_joined {
            meets &= !within(first, first_along, start.radius, lanes);
        }
        // Where the strand goes on the nearest point may, up to a radius along the ray.
        let reach = radius * lanes.shrink.sqrt();
        let beyond = (approach - nearest) * (change.depth + shrunk);
        let beyond = beyond.max(-reach).min(reach);
        (meets, goes_on.select(depth + beyond, depth))
    }
}

/// True where a point is within its radius of the ray: `from_ray` is the vector to it
/// in its plane of constant depth, and `along` that vector's product with the slope.
#[inline(always)]
fn within<S: Simd>(
    from_ray: [f32x16<S>; 2],
    along: f32x16<S>,
    radius: f32x16<S>,
    lanes: &RayLanes<S>,
) -> mask32x16<S> {
    fused(-along, along * lanes.shrink, dot(from_ray, from_ray)).simd_lt(radius * radius)
}
