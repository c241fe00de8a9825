//! Geometry at the hit of a ray.

use dsm_core::{Ray, Rgb};
use glam::DVec3;

use super::segment::SegmentTest;
use crate::scene::{Object, Shape};

/// An intersection of a ray with a surface or a strand.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Intersection {
    pub(crate) t: f64,
    pub(crate) opacity: Rgb,
    pub(crate) geometry: HitGeometry,
}

/// The geometry at an intersection, in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum HitGeometry {
    /// A surface, with its unit normal to either side, if it has an area.
    Surface { normal: Option<DVec3> },
    /// A strand: the point in its middle, the unit vector along it, and its
    /// radius there.
    Strand { middle: DVec3, along: DVec3, radius: f64 },
}

impl HitGeometry {
    /// The geometry where the ray hits a primitive of the object.
    pub(super) fn of(object: &Object, primitive: u32, ray: &Ray) -> Self {
        let to_world = object.to_world(ray.time());
        match &*object.shape {
            Shape::Mesh(mesh) => {
                let corners = mesh.corners(primitive as usize);
                let [a, b, c] = corners.map(|corner| corner.as_dvec3());
                let normal = (b - a).cross(c - a);
                Self::Surface { normal: to_world.transform_vector3(normal).try_normalize() }
            }
            Shape::Curves(curves) => {
                // A similarity: every axis is scaled alike.
                let scale = to_world.matrix3.x_axis.length();
                let ends = curves.segment(primitive as usize).map(|(end, radius)| {
                    (to_world.transform_point3(end.as_dvec3()), f64::from(radius) * scale)
                });
                let [(a, near_radius), (b, far_radius)] = ends;
                // Rounding may take a ray at the rim past it.
                let place =
                    SegmentTest::new(ray).crossing(ends, false).map_or(0.5, |hit| hit.along);
                Self::Strand {
                    middle: a + (b - a) * place,
                    along: (b - a).try_normalize().unwrap_or(DVec3::X),
                    radius: near_radius + (far_radius - near_radius) * place,
                }
            }
            Shape::Volume(_) => Self::Surface { normal: None },
        }
    }
}
