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

    /// The hit where the line passes a segment of a strand within its radius, which is
    /// linear between the ends: the segment is seen along the ray, and the point on it
    /// nearest to the ray is taken.
    ///
    /// A strand is met once for each stretch of it within its radius of the ray. Such
    /// a stretch is met at its first segment, so that one that `is_joined` to another
    /// is not met where the stretch has begun before. Where the stretch goes on
    /// beyond the segment, so does the nearest point, up to a radius along the ray.
    pub(crate) fn crossing(&self, ends: [(DVec3, f64); 2], is_joined: bool) -> Option<SegmentHit> {
        let [(a, near_radius), (b, far_radius)] = ends;
        let [a, b] = [a - self.origin, b - self.origin];
        let [a_t, b_t] = [a, b].map(|end| end.dot(self.direction) * self.per_length);
        // The ends on the plane across the ray.
        let across = a - self.direction * a_t;
        let step = b - self.direction * b_t - across;
        let length = step.length_squared();
        let nearest = if length > 0.0 { -across.dot(step) / length } else { 0.0 };
        let along = nearest.clamp(0.0, 1.0);
        let radius = near_radius + (far_radius - near_radius) * along;
        let is_within =
            |place: DVec3, radius: f64| radius > 0.0 && place.length_squared() <= radius * radius;
        if is_joined && is_within(across, near_radius) {
            return None;
        }
        // The same numbers as of the next segment's first end: rounding must not
        // lose a stretch between them.
        let goes_on = is_within(b - self.direction * b_t, far_radius);
        if !goes_on && !is_within(across + step * along, radius) {
            return None;
        }
        let mut t = a_t + (b_t - a_t) * along;
        if goes_on && nearest > 1.0 {
            let reach = radius * self.per_length.sqrt();
            t += ((nearest - 1.0) * (b_t - a_t)).clamp(-reach, reach);
        }
        Some(SegmentHit { t, along })
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
            SegmentTest::new(&ray).crossing(ends, false)
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
        let hit = SegmentTest::new(&ray).crossing(ends, false).unwrap();
        assert_eq!(hit, SegmentHit { t: 1.0, along: 0.0 });
    }

    #[test]
    fn a_segment_without_width_is_never_met() {
        let ends = [(DVec3::ZERO, 0.0), (DVec3::X, 0.0)];
        let ray = Ray::new(DVec3::new(0.5, 0.0, 1.0), DVec3::NEG_Z);
        assert_eq!(SegmentTest::new(&ray).crossing(ends, false), None);
    }

    /// The hits of a strand through `points`.
    fn hits(ray: &Ray, points: &[DVec3], radius: f64) -> Vec<f64> {
        let test = SegmentTest::new(ray);
        let crossing = |(index, ends): (usize, &[DVec3])| {
            test.crossing([(ends[0], radius), (ends[1], radius)], index > 0)
        };
        points.windows(2).enumerate().filter_map(crossing).map(|hit| hit.t).collect()
    }

    #[test]
    fn a_strand_is_met_once_a_crossing_however_it_is_cut() {
        let (from, to) = (DVec3::new(-1.0, 0.0, 0.5), DVec3::new(1.0, 0.25, -0.5));
        let cut = |pieces: u32| {
            let at = |piece: u32| from.lerp(to, f64::from(piece / 2 * 2) / f64::from(pieces));
            // Every other point twice.
            (0..=pieces).map(at).collect::<Vec<_>>()
        };
        for x in 0..300 {
            for y in 0..60 {
                let start = DVec3::new(f64::from(x) / 120.0 - 1.25, f64::from(y) / 60.0 - 0.5, 9.0);
                let ray = Ray::new(start, DVec3::new(0.01, 0.02, -1.0));
                let whole = hits(&ray, &[from, to], 0.2);
                for pieces in [2, 8, 64] {
                    let parts = hits(&ray, &cut(pieces), 0.2);
                    assert_eq!(parts.len(), whole.len(), "{start} in {pieces}");
                    assert!(parts.iter().zip(&whole).all(|(a, b)| (a - b).abs() < 0.2));
                }
            }
        }
    }

    #[test]
    fn a_curl_is_met_where_it_leaves_the_ray_and_comes_back() {
        // Around the ray, nearer than its radius, and then far away and back.
        let turn =
            |angle: f64, wide: f64| DVec3::new(angle.cos() * wide, angle.sin() * wide, angle);
        let near: Vec<_> = (0..40).map(|step| turn(f64::from(step), 0.05)).collect();
        let ray = Ray::new(DVec3::new(0.0, 0.0, 100.0), DVec3::NEG_Z);
        assert_eq!(hits(&ray, &near, 0.1).len(), 1);
        let mut far = near.clone();
        far.extend([DVec3::new(5.0, 0.0, 40.0), DVec3::new(0.0, 0.0, 50.0)]);
        assert_eq!(hits(&ray, &far, 0.1).len(), 2);
        // A sharp bend within reach of the ray on both legs, but not at the bend.
        let bend =
            [DVec3::new(-1.0, 0.0, 0.0), DVec3::new(1.0, 0.0, 0.0), DVec3::new(-1.0, 0.0, 1.0)];
        assert_eq!(hits(&ray, &bend, 0.1).len(), 2);
    }
}
