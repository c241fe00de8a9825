//! Keyframes, and what lies between them.

use glam::{DQuat, DVec4};

use super::malformed;
use crate::error::Result;

/// What happens between two keyframes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Interpolation {
    /// The value of the earlier one holds.
    Step,
    /// Values go linearly, rotations on the shortest arc.
    Linear,
    /// Cubic Hermite splines: each keyframe has a tangent before its value and one after.
    CubicSpline,
}

impl Interpolation {
    pub(super) fn of(name: Option<&str>) -> Result<Self> {
        Ok(match name {
            None | Some("LINEAR") => Self::Linear,
            Some("STEP") => Self::Step,
            Some("CUBICSPLINE") => Self::CubicSpline,
            Some(name) => {
                return Err(malformed(format!("interpolation {name:.40} is not known")));
            }
        })
    }
}

/// The keyframes around a time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Keys {
    interpolation: Interpolation,
    count: usize,
    /// The earlier of the two; the next one is the later.
    before: usize,
    /// How far on the way from the earlier to the later, in [0, 1].
    part: f64,
    /// Seconds between the two.
    length: f64,
}

impl Keys {
    /// Those around `time`, of keyframes at increasing `times`; before the first and
    /// after the last these hold.
    pub(super) fn new(times: &[[f32; 1]], time: f64, interpolation: Interpolation) -> Result<Self> {
        let ordered = times.windows(2).all(|pair| pair[0][0] < pair[1][0]);
        if times.is_empty() || !ordered || !times.iter().all(|[time]| time.is_finite()) {
            return Err(malformed("the times of its keyframes must increase".to_owned()));
        }
        let at = |index: usize| f64::from(times[index][0]);
        let later = times.partition_point(|&[key]| f64::from(key) <= time);
        let before = later.saturating_sub(1);
        let has_both = later > 0 && later < times.len();
        let length = if has_both { at(later) - at(before) } else { 0.0 };
        let part = if has_both { (time - at(before)) / length } else { 0.0 };
        Ok(Self { interpolation, count: times.len(), before, part, length })
    }

    /// The value between the keyframes' `values`, each of numbers that go on their own.
    pub(super) fn values<const N: usize>(&self, values: &[[f32; N]]) -> Result<[f64; N]> {
        self.check(values.len(), 1)?;
        let value = |at: usize| values[at].map(f64::from);
        Ok(std::array::from_fn(|part| self.between(|at| value(at)[part], 1, 0)))
    }

    /// The rotation between those of the keyframes.
    pub(super) fn rotation(&self, values: &[[f32; 4]]) -> Result<DQuat> {
        self.check(values.len(), 1)?;
        let value = |at: usize| DVec4::from(values[at].map(f64::from));
        if self.interpolation == Interpolation::Linear && self.part > 0.0 {
            let [from, to] = [value(self.before), value(self.before + 1)];
            return Ok(slerp(from, to, self.part));
        }
        let numbers = self.values(values)?;
        Ok(rotation_of(numbers))
    }

    /// The weights of so many morph targets.
    pub(super) fn weights(&self, values: &[[f32; 1]], targets: usize) -> Result<Vec<f32>> {
        self.check(values.len(), targets)?;
        let value = |at: usize| f64::from(values[at][0]);
        Ok((0..targets).map(|target| self.between(value, targets, target) as f32).collect())
    }

    /// One number of `width` between two keyframes, of numbers in the file's order.
    fn between(&self, value: impl Fn(usize) -> f64, width: usize, number: usize) -> f64 {
        let (before, after) = (self.before, self.before + 1);
        let t = self.part;
        if self.interpolation != Interpolation::CubicSpline {
            let from = value(before * width + number);
            if self.interpolation == Interpolation::Step || t == 0.0 {
                return from;
            }
            let to = value(after * width + number);
            return from * (1.0 - t) + to * t;
        }
        // A keyframe is its tangents before, its values, its tangents after.
        let of = |key: usize, what: usize| value((3 * key + what) * width + number);
        if t == 0.0 {
            return of(before, 1);
        }
        let [square, cube] = [t * t, t * t * t];
        (2.0 * cube - 3.0 * square + 1.0) * of(before, 1)
            + self.length * (cube - 2.0 * square + t) * of(before, 2)
            + (3.0 * square - 2.0 * cube) * of(after, 1)
            + self.length * (cube - square) * of(after, 0)
    }

    fn check(&self, found: usize, width: usize) -> Result<()> {
        let parts = if self.interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        let wanted = self.count.checked_mul(parts).and_then(|count| count.checked_mul(width));
        if wanted == Some(found) {
            return Ok(());
        }
        Err(malformed(format!("{found} values for {} keyframes", self.count)))
    }
}

/// Between two rotations on the shortest arc between them, evenly.
fn slerp(from: DVec4, to: DVec4, part: f64) -> DQuat {
    let (from, to) = (unit(from), unit(to));
    let to = if from.dot(to) < 0.0 { -to } else { to };
    // As exact for the smallest angles as for others.
    let angle = 2.0 * (to - from).length().atan2((to + from).length());
    let sin = angle.sin();
    if sin == 0.0 {
        return DQuat::from_vec4(from);
    }
    let between = from * ((1.0 - part) * angle).sin() + to * (part * angle).sin();
    DQuat::from_vec4(unit(between / sin))
}

/// A rotation as a file has it: rounded.
pub(super) fn rotation_of(numbers: [f64; 4]) -> DQuat {
    DQuat::from_vec4(unit(numbers.into()))
}

/// A rotation's quaternion of length 1; that of none if it is none.
fn unit(rotation: DVec4) -> DVec4 {
    let length = rotation.length();
    if length > 0.0 && length.is_finite() { rotation / length } else { DVec4::W }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keyframes_around_a_time_are_found() {
        let times = [[1.0], [2.0], [4.0]];
        for (time, before, part) in [
            (0.0, 0, 0.0),
            (1.0, 0, 0.0),
            (1.5, 0, 0.5),
            (2.0, 1, 0.0),
            (3.5, 1, 0.75),
            (9.0, 2, 0.0),
        ] {
            let keys = Keys::new(&times, time, Interpolation::Linear).unwrap();
            assert_eq!((keys.before, keys.part), (before, part), "{time}");
        }
        for times in
            [&[][..], &[[1.0], [1.0]], &[[2.0], [1.0]], &[[f32::NAN]], &[[0.0], [f32::INFINITY]]]
        {
            assert!(Keys::new(times, 0.0, Interpolation::Step).is_err(), "{times:?}");
        }
    }

    #[test]
    fn numbers_step_go_straight_or_on_a_spline() {
        let times = [[1.0], [3.0]];
        let at = |time, interpolation, values: &[[f32; 1]]| {
            Keys::new(&times, time, interpolation).unwrap().values(values).unwrap()[0]
        };
        assert_eq!(at(2.9, Interpolation::Step, &[[5.0], [9.0]]), 5.0);
        assert_eq!(at(3.0, Interpolation::Step, &[[5.0], [9.0]]), 9.0);
        assert_eq!(at(1.5, Interpolation::Linear, &[[5.0], [9.0]]), 6.0);
        // The cubic through value 1 with slope 2 and value −1 with slope 0.5, at a quarter.
        let spline = [[7.0], [1.0], [2.0], [0.5], [-1.0], [7.0]];
        let (h00, h10, h01, h11) = (0.84375, 0.140625, 0.15625, -0.046875);
        let want = h00 + 2.0 * h10 * 2.0 - h01 + 2.0 * h11 * 0.5;
        assert!((at(1.5, Interpolation::CubicSpline, &spline) - want).abs() < 1e-15);
        assert_eq!(at(0.0, Interpolation::CubicSpline, &spline), 1.0);
        assert_eq!(at(8.0, Interpolation::CubicSpline, &spline), -1.0);
        let keys = Keys::new(&times, 1.5, Interpolation::Linear).unwrap();
        assert!(keys.values(&[[1.0]]).is_err() && keys.weights(&[[1.0]; 5], 2).is_err());
        assert_eq!(keys.weights(&[[0.0], [4.0], [8.0], [0.0]], 2).unwrap(), [2.0, 3.0]);
    }

    #[test]
    fn rotations_turn_evenly_on_the_shortest_arc() {
        let times = [[0.0], [1.0]];
        for angle in [1e-9_f64, 0.02, 1.0, 3.0, 4.0, 6.0] {
            let [sin, cos] = [(angle / 2.0).sin() as f32, (angle / 2.0).cos() as f32];
            let values = [[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, sin, cos]];
            let found = Keys::new(&times, 0.25, Interpolation::Linear).unwrap().rotation(&values);
            // The file's numbers are rounded: their own angle.
            let angle = 2.0 * f64::from(sin).atan2(f64::from(cos));
            let shortest =
                if angle > std::f64::consts::PI { angle - std::f64::consts::TAU } else { angle };
            let want = DQuat::from_rotation_z(0.25 * shortest);
            let found = found.unwrap();
            assert!((found.dot(want).abs() - 1.0).abs() < 1e-15, "{angle}: {found} and not {want}");
            let error = (found.z * want.w - found.w * want.z).abs();
            assert!(error < 1e-15, "{angle}: {error}");
        }
    }
}
