//! A naive `f64` oracle, and cameras for it.

use dsm_core::{SamplePoint, ShadowCamera};
use glam::{DMat2, DMat4, DVec2, DVec3, DVec4, Vec3};

use super::segment::Segment;

/// A perspective camera that looks down −z: its angle from side to side, in
/// degrees, and the width of its map over the height.
pub(super) fn perspective(degrees: f64, aspect: f64) -> ShadowCamera {
    let half = (degrees.to_radians() / 2.0).tan();
    camera(DMat4::from_cols(
        DVec4::new(0.5 / half, 0.0, 0.0, 0.0),
        DVec4::new(0.0, -0.5 * aspect / half, 0.0, 0.0),
        DVec4::new(-0.5, -0.5, 1.0, -1.0),
        DVec4::ZERO,
    ))
}

/// An orthographic one: the width of its view.
pub(super) fn orthographic(width: f64, aspect: f64) -> ShadowCamera {
    camera(DMat4::from_cols(
        DVec4::new(1.0 / width, 0.0, 0.0, 0.0),
        DVec4::new(0.0, -aspect / width, 0.0, 0.0),
        DVec4::Z,
        DVec4::new(0.5, 0.5, 0.0, 1.0),
    ))
}

fn camera(projection: DMat4) -> ShadowCamera {
    ShadowCamera { world_to_camera: Some(DMat4::IDENTITY), world_to_ndc: Some(projection) }
}

/// This camera elsewhere in the world.
pub(super) fn placed(camera: ShadowCamera, view: DMat4) -> ShadowCamera {
    let placed = |matrix: Option<DMat4>| matrix.map(|matrix| matrix * view);
    ShadowCamera {
        world_to_camera: placed(camera.world_to_camera),
        world_to_ndc: placed(camera.world_to_ndc),
    }
}

/// A ray in camera space: a point, and a direction that gains 1 in depth.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ray {
    start: DVec3,
    direction: DVec3,
}

impl Ray {
    /// The ray through a sample point of a map of `size` pixels.
    pub(super) fn new(camera: &ShadowCamera, size: [u32; 2], point: SamplePoint) -> Self {
        let to_camera = camera.world_to_camera.unwrap();
        let projection = camera.world_to_ndc.unwrap() * to_camera.inverse();
        let ndc = DVec2::new(point.x, point.y) / DVec2::from(size.map(f64::from));
        // Where both planes of the point meet a plane of constant depth.
        let at = |depth: f64| {
            let planes = [0, 1].map(|axis| projection.row(axis) - projection.row(3) * ndc[axis]);
            let rows = DMat2::from_cols_array_2d(&planes.map(|plane| [plane.x, plane.y]));
            let rest = DVec2::from(planes.map(|plane| depth * plane.z - plane.w));
            (rows.transpose().inverse() * rest).extend(-depth)
        };
        let (start, next) = (at(0.0), at(1.0));
        Self { start, direction: next - start }
    }

    /// The vector from the ray to a point, in the point's plane of constant depth.
    fn to(&self, point: DVec3) -> DVec2 {
        (point - self.start + self.direction * point.z).truncate()
    }
}

/// The expected outcome of a ray against a primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Expected {
    /// A hit at this depth, give or take that much.
    Hit(f64, f64),
    Miss,
    /// A hit or a miss: so close that rounding decides.
    Uncertain,
}

/// The outcome of a margin that decides (positive: yes) and what rounding may do to
/// it, and of a depth.
fn expected(margin: f64, rounding: f64, depth: f64, blur: f64) -> Expected {
    if margin.is_nan() || margin < -rounding {
        Expected::Miss
    } else if margin <= rounding || depth.abs() <= blur {
        Expected::Uncertain
    } else if depth > 0.0 {
        Expected::Hit(depth, blur)
    } else {
        Expected::Miss
    }
}

fn lerp(keys: [Vec3; 2], time: f32) -> DVec3 {
    let [open, close] = keys.map(|key| key.as_dvec3());
    open + (close - open) * f64::from(time)
}

/// A ray against a segment: where the two lines come closest, unless the strand was
/// within reach before.
pub(super) fn segment(ray: &Ray, keys: &[Segment; 2], time: f32) -> Expected {
    let [a, b] = [0, 1].map(|end| lerp(keys.map(|key| key.ends[end]), time));
    let [thick, thin] = [0, 1].map(|end| {
        let [open, close] = keys.map(|key| f64::from(key.radii[end]));
        open + (close - open) * f64::from(time)
    });
    let unit = ray.direction.normalize();
    let across = |vector: DVec3| vector - unit * vector.dot(unit);
    let (first, along) = (across(a - ray.start), across(b - a));
    let approach = -first.dot(along) / along.length_squared();
    let approach = if approach.is_nan() { 0.0 } else { approach.max(0.0) };
    let nearest = approach.min(1.0);
    let distance = (first + along * nearest).length();
    let radius = thick + (thin - thick) * nearest;
    let on_ray = (a + (b - a) * nearest - ray.start).dot(unit);
    let to_end = (thin - (first + along).length(), thin > 0.0);
    let beyond = (approach - nearest) * (b - a).dot(unit);
    let beyond = if to_end.1 && to_end.0 > 0.0 { beyond.clamp(-radius, radius) } else { 0.0 };
    let depth = -(ray.start + unit * (on_ray + beyond)).z;
    // What moves is rounded where it was, too.
    let moved = (0..2).map(|end| keys[0].ends[end].distance(keys[1].ends[end]));
    let moved = f64::from(moved.fold(0.0, f32::max));
    let size = first.length() + along.length() + moved;
    let rounding = 1e-6 * (radius + size);
    // Of a segment along the ray, hardly a point is nearer than the others.
    let off = 2e-6 * size / along.length() * (1.0 + approach);
    let length = (b - a).length();
    let sliding = off.min(1.0) * length + (off * length).min(2.0 * radius);
    let blur = 1e-5 * depth.abs() + 1e-6 * size + sliding;
    // Where rounding decides whether the strand goes on, so it does of the depth.
    let at_end = if to_end.1 && to_end.0.abs() <= rounding { radius } else { 0.0 };
    let before = thick - first.length();
    if keys[0].is_joined && thick > 0.0 && before > -rounding {
        return if before > rounding { Expected::Miss } else { Expected::Uncertain };
    }
    let margin = if radius > 0.0 { radius - distance } else { f64::NAN };
    let margin = if to_end.1 { margin.max(to_end.0) } else { margin };
    expected(margin, rounding, depth, blur + at_end)
}

/// A ray against a triangle.
pub(super) fn triangle(ray: &Ray, keys: &[[Vec3; 3]; 2], time: f32) -> Expected {
    let corners = [0, 1, 2].map(|corner| lerp(keys.map(|key| key[corner]), time));
    let seen = corners.map(|corner| ray.to(corner));
    let weights = [0, 1, 2].map(|at| seen[(at + 1) % 3].perp_dot(seen[(at + 2) % 3]));
    let area: f64 = weights.iter().sum();
    let least = weights.iter().map(|weight| weight * area.signum()).fold(f64::INFINITY, f64::min);
    let moved = (0..3).map(|corner| keys[0][corner].distance(keys[1][corner]));
    let moved = f64::from(moved.fold(0.0, f32::max));
    let size = moved + seen.iter().map(|corner| corner.length()).fold(0.0, f64::max);
    let rounding = 1e-6 * size * size;
    let depth = |corner: usize| -corners[corner].z;
    let weighted: f64 = (0..3).map(|corner| weights[corner] * depth(corner)).sum();
    let depths = [depth(0), depth(1), depth(2)];
    let range = depths.iter().fold(0.0, |range: f64, depth| range.max((depth - depths[0]).abs()));
    let blur = (weighted / area).abs() * 1e-5 + rounding / area.abs() * range;
    if area.abs() <= rounding && least >= -rounding {
        return Expected::Uncertain;
    }
    expected(least, rounding, weighted / area, blur)
}
