//! Intersection of a ray with a triangle.

use dsm_core::Ray;
use glam::DVec3;

/// The ray's view of triangles: corners are sheared so that the ray becomes an
/// axis (Woop, Benthin & Wald 2013). Triangles that share an edge compute the
/// same numbers for it, so a ray through the edge meets exactly one of two
/// triangles on either side.
pub(crate) struct TriangleTest {
    origin: DVec3,
    axes: [usize; 3],
    shear: DVec3,
}

/// A crossing: the ray's parameter, and the weights of the second and third
/// corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Crossing {
    pub(crate) t: f64,
    pub(crate) u: f64,
    pub(crate) v: f64,
}

impl TriangleTest {
    pub(crate) fn new(ray: &Ray) -> Self {
        let direction = ray.direction();
        let size = direction.abs();
        let z = if size.z >= size.x && size.z >= size.y {
            2
        } else if size.y >= size.x {
            1
        } else {
            0
        };
        let axes = [(z + 1) % 3, (z + 2) % 3, z];
        let along = direction[z];
        let shear = DVec3::new(direction[axes[0]] / along, direction[axes[1]] / along, 1.0 / along);
        Self { origin: ray.origin(), axes, shear }
    }

    /// The crossing of the line with the triangle, from either side.
    pub(crate) fn crossing(&self, corners: [DVec3; 3]) -> Option<Crossing> {
        let [x, y, z] = self.axes;
        let [a, b, c] = corners.map(|corner| {
            let from = corner - self.origin;
            DVec3::new(
                from[x] - self.shear.x * from[z],
                from[y] - self.shear.y * from[z],
                from[z] * self.shear.z,
            )
        });
        // Twice the areas that the ray and each edge span; exactly opposite for
        // an edge walked the other way.
        let areas = [cross(b, c), cross(c, a), cross(a, b)];
        let whole = areas[0] + areas[1] + areas[2];
        if whole == 0.0 || !whole.is_finite() {
            return None;
        }
        let turned = whole < 0.0;
        let edges = [(b, c), (c, a), (a, b)];
        for (area, (from, to)) in areas.into_iter().zip(edges) {
            let area = if turned { -area } else { area };
            let (from, to) = if turned { (to, from) } else { (from, to) };
            if area < 0.0 || (area == 0.0 && !owns_edge(from, to)) {
                return None;
            }
        }
        let t = (areas[0] * a.z + areas[1] * b.z + areas[2] * c.z) / whole;
        Some(Crossing { t, u: areas[1] / whole, v: areas[2] / whole })
    }
}

fn cross(a: DVec3, b: DVec3) -> f64 {
    a.x * b.y - a.y * b.x
}

/// True if a ray through an edge hits this triangle of the two beside it: the one
/// that walks it upwards, counterclockwise.
fn owns_edge(from: DVec3, to: DVec3) -> bool {
    to.y > from.y || (to.y == from.y && to.x < from.x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_crossing_has_a_place_from_either_side() {
        let corners = [DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 2.0];
        let origin = DVec3::new(1.0, 0.5, 3.0);
        let down = Ray::new(origin, DVec3::new(0.0, 0.0, -2.0));
        let hit = TriangleTest::new(&down).crossing(corners).unwrap();
        assert_eq!(hit, Crossing { t: 1.5, u: 0.25, v: 0.25 });
        let [a, b, c] = corners;
        let hit = TriangleTest::new(&down).crossing([a, c, b]).unwrap();
        assert_eq!(hit, Crossing { t: 1.5, u: 0.25, v: 0.25 });
        let away = Ray::new(origin + DVec3::X * 3.0, DVec3::NEG_Z);
        assert_eq!(TriangleTest::new(&away).crossing(corners), None);
        let along = Ray::new(DVec3::new(-1.0, 0.5, 0.0), DVec3::X);
        assert_eq!(TriangleTest::new(&along).crossing(corners), None);
    }

    #[test]
    fn rays_through_edges_and_corners_of_a_fan_meet_one_triangle() {
        // A fan around the origin in the plane z = 0 whose edges lie on the
        // grid that the rays come from.
        let rim: [[f64; 2]; 8] = [
            [2.0, 0.0],
            [2.0, 2.0],
            [0.0, 2.0],
            [-2.0, 2.0],
            [-2.0, 0.0],
            [-2.0, -2.0],
            [0.0, -2.0],
            [2.0, -2.0],
        ];
        let corner = |at: usize| DVec3::new(rim[at % 8][0], rim[at % 8][1], 0.0);
        for (x, y) in (-7..8).flat_map(|x| (-7..8).map(move |y| (x, y))) {
            let through = DVec3::new(f64::from(x) / 4.0, f64::from(y) / 4.0, 0.0);
            for direction in [DVec3::Z, DVec3::new(0.25, -0.5, -1.0), DVec3::new(3.0, 1.0, 0.5)] {
                let ray = Ray::new(through - direction * 2.0, direction);
                let test = TriangleTest::new(&ray);
                let count = (0..8)
                    .filter(|&at| {
                        // Alternate the winding: sides must not matter.
                        let (b, c) = (corner(at), corner(at + 1));
                        let (b, c) = if at % 2 == 0 { (b, c) } else { (c, b) };
                        test.crossing([DVec3::ZERO, b, c]).is_some()
                    })
                    .count();
                assert_eq!(count, 1, "{through} {direction}");
            }
        }
    }
}
