//! Plain surfaces.

use dsm_core::{LightExtent, Projection, View};
use glam::{DVec3, Vec3};

use crate::error::Result;
use crate::mesh::TriangleMesh;
use crate::scene::{Object, Shape};
use crate::view::{Camera, Light};

/// A full turn.
pub(super) const TURN: f64 = std::f64::consts::TAU;

/// A square at height 0 that reaches `half` to either side.
pub(super) fn floor(half: f32) -> Result<Object> {
    let corner = |x, z| Vec3::new(x, 0.0, z);
    let corners =
        vec![corner(-half, -half), corner(half, -half), corner(half, half), corner(-half, half)];
    Ok(Object::new(Shape::Mesh(TriangleMesh::new(corners, vec![[0, 2, 1], [0, 3, 2]])?)))
}

/// A grid of (`columns` + 1) × (`rows` + 1) points, each a function of its
/// column and row; the quads that `keep` takes become two triangles each.
pub(super) fn grid(
    columns: u32,
    rows: u32,
    point: impl Fn(u32, u32) -> DVec3,
    keep: impl Fn(u32, u32) -> bool,
) -> Result<TriangleMesh> {
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for row in 0..=rows {
        for column in 0..=columns {
            positions.push(point(column, row).as_vec3());
            if column < columns && row < rows && keep(column, row) {
                let near = row * (columns + 1) + column;
                let far = near + columns + 1;
                triangles.extend([[near, near + 1, far], [near + 1, far + 1, far]]);
            }
        }
    }
    TriangleMesh::new(positions, triangles)
}

/// A sphere of `slices` × `stacks` quads; only the slices that `keep` takes.
pub(super) fn sphere(
    centre: DVec3,
    radius: f64,
    slices: u32,
    stacks: u32,
    keep: impl Fn(u32) -> bool,
) -> Result<TriangleMesh> {
    let point = |slice: u32, stack: u32| {
        let (sin, cos) = libm::sincos(TURN * f64::from(slice % slices) / f64::from(slices));
        let (high, wide) = match stack {
            0 => (1.0, 0.0),
            stack if stack == stacks => (-1.0, 0.0),
            stack => {
                let (wide, high) = libm::sincos(0.5 * TURN * f64::from(stack) / f64::from(stacks));
                (high, wide)
            }
        };
        centre + DVec3::new(wide * cos, high, -wide * sin) * radius
    };
    grid(slices, stacks, point, |slice, _| keep(slice))
}

/// The side of a cylinder from `from` to `to`, open at its ends.
pub(super) fn pipe(from: DVec3, to: DVec3, radius: f64, sides: u32) -> Result<TriangleMesh> {
    let axis = (to - from) / (to - from).length();
    // Any vector across will do, if it always is the same.
    let other = if axis.x.abs() < 0.5 { DVec3::X } else { DVec3::Y };
    let right = axis.cross(other);
    let right = right / right.length();
    let up = axis.cross(right);
    let point = |side: u32, end: u32| {
        let (sin, cos) = libm::sincos(TURN * f64::from(side % sides) / f64::from(sides));
        let centre = if end == 0 { from } else { to };
        centre + (right * cos + up * sin) * radius
    };
    grid(sides, 1, point, |_, _| true)
}

/// A light whose shadow camera looks at `target`.
pub(super) fn light(eye: DVec3, target: DVec3, fov: f64, extent: LightExtent) -> Light {
    let view = View { eye, target, up: DVec3::Y };
    Light { view, projection: Projection::Perspective { fov }, extent }
}

/// A camera of 640 × 360 pixels.
pub(super) fn camera(eye: DVec3, target: DVec3, fov: f64) -> Camera {
    Camera { view: View { eye, target, up: DVec3::Y }, fov, resolution: [640, 360] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sphere_is_closed_and_round() {
        let centre = DVec3::new(1.0, 2.0, 3.0);
        let sphere = sphere(centre, 2.0, 24, 12, |_| true).unwrap();
        assert_eq!(sphere.triangles().len(), 24 * 12 * 2);
        for position in sphere.positions() {
            assert!(((position.as_dvec3() - centre).length() - 2.0).abs() < 1e-6);
        }
        // The seam is one line.
        assert_eq!(sphere.positions()[25], sphere.positions()[25 + 24]);
    }

    #[test]
    fn a_pipe_keeps_its_radius() {
        let (from, to) = (DVec3::new(-1.0, 0.5, 0.0), DVec3::new(2.0, 1.5, 0.5));
        let pipe = pipe(from, to, 0.25, 16).unwrap();
        assert_eq!(pipe.triangles().len(), 32);
        let axis = (to - from).normalize();
        for position in pipe.positions() {
            let from = position.as_dvec3() - from;
            assert!((from.reject_from_normalized(axis).length() - 0.25).abs() < 1e-6);
        }
    }
}
