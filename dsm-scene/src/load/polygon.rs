//! Polygons as triangles.

use earcut::Earcut;
use glam::{DVec3, Vec3};

use crate::error::{Error, Result};

/// Cutting ears takes a time that is at worst quadratic: so many squares of numbers of
/// corners, of one polygon and of all.
const MOST_STEPS: [u64; 2] = [1 << 28, 1 << 30];

/// Cuts polygons into triangles. Keeps its memory from one polygon to the next.
///
/// A convex polygon is a fan around its first corner. Others are cut in the plane of
/// the two coordinate axes in which they are largest, by ears (David Eberly,
/// *Triangulation by Ear Clipping*, 2002): the triangles cover what the polygon
/// covers, whichever corner comes first. One without an area stays a fan.
#[derive(Default)]
pub(super) struct PolygonCutter {
    earcut: Earcut<f64>,
    flat: Vec<[f64; 2]>,
    ears: Vec<u32>,
    triangles: Vec<[u32; 3]>,
    steps: u64,
}

impl PolygonCutter {
    /// The triangles of a polygon, as indices of its corners. Fewer than three make
    /// none.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] for a polygon that is not convex with more than 16,384
    /// corners, or as many others that theirs add up to 2³⁰ squared.
    pub(super) fn cut(&mut self, corners: &[Vec3]) -> Result<&[[u32; 3]]> {
        self.triangles.clear();
        if corners.len() > 3 && !self.is_convex(corners) {
            let steps = (corners.len() as u64).saturating_pow(2);
            self.steps = self.steps.saturating_add(steps);
            for (count, limit) in [steps, self.steps].into_iter().zip(MOST_STEPS) {
                if count > limit {
                    let what = "squares of the numbers of corners of polygons";
                    return Err(Error::TooLarge { what, count, limit });
                }
            }
            self.earcut.earcut(self.flat.iter().copied(), &[], &mut self.ears);
            self.triangles.extend(self.ears.as_chunks::<3>().0);
        }
        if self.triangles.is_empty() {
            let last = corners.len() as u32;
            self.triangles.extend((2..last).map(|corner| [0, corner - 1, corner]));
        }
        Ok(&self.triangles)
    }

    /// True if the polygon is a fan around its first corner: all triangles of the fan
    /// are turned the same way, or it has no area. Leaves the flat polygon behind.
    fn is_convex(&mut self, corners: &[Vec3]) -> bool {
        let first = corners[0].as_dvec3();
        let from_first = |corner: &Vec3| corner.as_dvec3() - first;
        let pairs = corners.windows(2).skip(1);
        let normal: DVec3 =
            pairs.map(|pair| from_first(&pair[0]).cross(from_first(&pair[1]))).sum();
        if !normal.is_finite() || normal == DVec3::ZERO {
            return true;
        }
        let size = normal.abs();
        let flatten = |place: DVec3| {
            if size.z >= size.x && size.z >= size.y {
                [place.x, place.y]
            } else if size.y >= size.x {
                [place.z, place.x]
            } else {
                [place.y, place.z]
            }
        };
        self.flat.clear();
        self.flat.extend(corners.iter().map(|corner| flatten(from_first(corner))));
        let sides = self.flat.windows(2).skip(1);
        let mut turns = sides.map(|pair| pair[0][0] * pair[1][1] - pair[0][1] * pair[1][0]);
        let mut signs = [false; 2];
        turns.all(|turn| {
            signs[0] |= turn > 0.0;
            signs[1] |= turn < 0.0;
            !(signs[0] && signs[1])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DMat3, DVec2};

    /// How often the triangles cover `place`, seen along z.
    fn covered(corners: &[Vec3], triangles: &[[u32; 3]], place: DVec2) -> usize {
        let inside = |triangle: &&[u32; 3]| {
            let [a, b, c] = triangle.map(|at| corners[at as usize].as_dvec3().truncate() - place);
            let sides = [a.perp_dot(b), b.perp_dot(c), c.perp_dot(a)];
            sides.iter().all(|&side| side > 0.0) || sides.iter().all(|&side| side < 0.0)
        };
        triangles.iter().filter(inside).count()
    }

    /// True if `place` is in the polygon, by the crossings of a ray.
    fn within(corners: &[Vec3], place: DVec2) -> bool {
        let mut inside = false;
        for at in 0..corners.len() {
            let [a, b] = [corners[at], corners[(at + 1) % corners.len()]]
                .map(|corner| corner.as_dvec3().truncate());
            if (a.y > place.y) != (b.y > place.y) {
                let x = a.x + (place.y - a.y) / (b.y - a.y) * (b.x - a.x);
                inside ^= x > place.x;
            }
        }
        inside
    }

    fn check(corners: &[Vec3], name: &str) {
        let mut cutter = PolygonCutter::default();
        for first in 0..corners.len() {
            for backwards in [false, true] {
                let mut rolled = corners.to_vec();
                rolled.rotate_left(first);
                if backwards {
                    rolled.reverse();
                }
                let triangles = cutter.cut(&rolled).unwrap();
                for step in 0..400 {
                    // No place on a side.
                    let place = DVec2::new(f64::from(step % 20), f64::from(step / 20)) / 10.0;
                    let place = place - DVec2::new(0.9712, 0.9623) + f64::from(step) * 1e-5;
                    let want = usize::from(within(corners, place));
                    let found = covered(&rolled, triangles, place);
                    assert_eq!(found, want, "{name} from {first}, {backwards}: {place}");
                }
            }
        }
    }

    fn flat(points: &[[f32; 2]]) -> Vec<Vec3> {
        points.iter().map(|&[x, y]| Vec3::new(x, y, 0.0)).collect()
    }

    #[test]
    fn triangles_cover_what_the_polygon_covers() {
        let c = [
            [-1.0, -1.0],
            [1.0, -1.0],
            [1.0, -0.5],
            [-0.5, -0.5],
            [-0.5, 0.5],
            [1.0, 0.5],
            [1.0, 1.0],
            [-1.0, 1.0],
        ];
        check(&flat(&c), "a C");
        check(&flat(&[[-1.0, -1.0], [0.0, -0.5], [1.0, -1.0], [0.0, 1.0]]), "an arrow");
        let star: Vec<[f32; 2]> = (0..22)
            .map(|at| {
                let (angle, size) = (at as f32 * 0.285_599, if at % 2 == 0 { 0.95 } else { 0.3 });
                [size * libm::cosf(angle), size * libm::sinf(angle)]
            })
            .collect();
        check(&flat(&star), "a star");
        // Not in a plane, and a ring with a slit.
        let bent: Vec<Vec3> =
            flat(&c).iter().map(|at| *at + Vec3::Z * (at.x * at.y * 0.2)).collect();
        check(&bent, "bent");
        let ring = [
            [-0.9, -0.9],
            [0.9, -0.9],
            [0.9, 0.9],
            [-0.9, 0.9],
            [-0.9, -0.9],
            [-0.4, -0.4],
            [-0.4, 0.4],
            [0.4, 0.4],
            [0.4, -0.4],
            [-0.4, -0.4],
        ];
        check(&flat(&ring), "a ring");
        check(&flat(&[[-0.9, -0.9], [0.0, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]]), "a T");
    }

    #[test]
    fn no_plane_matters() {
        let arrow = flat(&[[-1.0, -1.0], [0.0, -0.5], [1.0, -1.0], [0.0, 1.0]]);
        for (scale, angle) in [(1e-12, 0.5), (1.0, 1.2), (1e12, 2.0), (1.0, 1.57)] {
            let turn = DMat3::from_rotation_y(angle) * DMat3::from_rotation_x(angle / 2.0);
            let placed = |at: &Vec3| (turn * at.as_dvec3() * scale).as_vec3();
            let corners: Vec<Vec3> = arrow.iter().map(placed).collect();
            let area: f64 = PolygonCutter::default()
                .cut(&corners)
                .unwrap()
                .iter()
                .map(|triangle| {
                    let [a, b, c] = triangle.map(|at| corners[at as usize].as_dvec3());
                    (b - a).cross(c - a).length() / 2.0
                })
                .sum();
            assert!((area / scale / scale - 1.5).abs() < 1e-5, "{scale} {angle}: {area}");
        }
    }

    #[test]
    fn odd_polygons_end() {
        let mut cutter = PolygonCutter::default();
        for corners in 0..3 {
            assert!(cutter.cut(&vec![Vec3::ONE; corners]).unwrap().is_empty());
        }
        assert_eq!(cutter.cut(&[Vec3::ONE; 5]).unwrap().len(), 3, "without an area");
        for odd in [f32::NAN, f32::INFINITY, f32::MAX] {
            let corners = [Vec3::ZERO, Vec3::X, Vec3::new(odd, 1.0, 0.0), Vec3::new(0.2, 0.1, 0.0)];
            for triangle in cutter.cut(&corners).unwrap() {
                assert!(triangle.iter().all(|&corner| corner < 4));
            }
        }
        // A crossing in every corner.
        let tangle = |count: usize| -> Vec<Vec3> {
            let number = |at: usize| (at.wrapping_mul(2_654_435_761) >> 7 & 0xffff) as f32;
            (0..count).map(|at| Vec3::new(number(at), number(at * 31 + 7), 0.0)).collect()
        };
        let started = std::time::Instant::now();
        cutter.cut(&tangle(2000)).unwrap();
        assert!(started.elapsed().as_secs() < 60, "{:?}", started.elapsed());
        assert!(matches!(cutter.cut(&tangle((1 << 14) + 1)), Err(Error::TooLarge { .. })));
        cutter.steps = MOST_STEPS[1];
        assert!(matches!(cutter.cut(&tangle(5)), Err(Error::TooLarge { .. })));
    }
}
