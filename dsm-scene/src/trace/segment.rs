//! Intersection of a ray with a segment of a curve.

use dsm_core::Ray;
use glam::DVec3;

/// The ray's view of segments.
pub(crate) struct SegmentTest {
    origin: DVec3,
    direction: DVec3,
    per_length: f64,
}

/// A hit of a segment: the ray's parameter, and the place along the segment in
/// [0, 1].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SegmentHit {
    pub(crate) t: f64,
    pub(crate) along: f64,
}

impl SegmentTest {
    pub(crate) fn new(ray: &Ray) -> Self {
        let direction = ray.direction();
        Self { origin: ray.origin(), direction, per_length: 1.0 / direction.length_squared() }
    }

    /// The hit where the line passes the segment within its radius, which is linear
    /// between the ends: the segment is seen along the ray, and the
    /// point on it nearest to the ray is taken.
    pub(crate) fn intersection(&self, ends: [(DVec3, f64); 2]) -> Option<SegmentHit> {
        let [(a, near_radius), (b, far_radius)] = ends;
        let [a, b] = [a - self.origin, b - self.origin];
        let [a_t, b_t] = [a, b].map(|end| end.dot(self.direction) * self.per_length);
        // The ends on the plane across the ray.
        let across = a - self.direction * a_t;
        let step = b - self.direction * b_t - across;
        let length = step.length_squared();
        let along = if length > 0.0 { (-across.dot(step) / length).clamp(0.0, 1.0) } else { 0.0 };
        let radius = near_radius + (far_radius - near_radius) * along;
        let distance = (across + step * along).length_squared();
        (radius > 0.0 && distance <= radius * radius)
            .then_some(SegmentHit { t: a_t + (b_t - a_t) * along, along })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_meets_a_ribbon_within_its_width() {
        // From (0, 0, 1) to (4, 0, 3), radius 0.1 to 0.3; rays along −z.
        let ends = [(DVec3::new(0.0, 0.0, 1.0), 0.1), (DVec3::new(4.0, 0.0, 3.0), 0.3)];
        let meet = |x: f64, y: f64| {
            let ray = Ray::new(DVec3::new(x, y, 10.0), DVec3::new(0.0, 0.0, -2.0));
            SegmentTest::new(&ray).intersection(ends)
        };
        assert_eq!(meet(1.0, 0.149), Some(SegmentHit { t: 4.25, along: 0.25 }));
        assert_eq!(meet(1.0, 0.151), None);
        assert!(meet(3.0, 0.249).is_some() && meet(3.0, 0.251).is_none());
        // Around the ends it is round.
        assert!(meet(-0.09, 0.0).is_some() && meet(-0.11, 0.0).is_none());
        assert!(meet(4.2, 0.2).is_some() && meet(4.22, 0.22).is_none());
    }

    #[test]
    fn a_segment_along_the_ray_is_met_at_its_first_end() {
        let ends = [(DVec3::Z, 0.1), (DVec3::Z * 3.0, 0.1)];
        let ray = Ray::new(DVec3::new(0.05, 0.0, 0.0), DVec3::Z);
        let hit = SegmentTest::new(&ray).intersection(ends).unwrap();
        assert_eq!(hit, SegmentHit { t: 1.0, along: 0.0 });
    }

    #[test]
    fn a_segment_without_width_is_never_met() {
        let ends = [(DVec3::ZERO, 0.0), (DVec3::X, 0.0)];
        let ray = Ray::new(DVec3::new(0.5, 0.0, 1.0), DVec3::NEG_Z);
        assert_eq!(SegmentTest::new(&ray).intersection(ends), None);
    }
}
