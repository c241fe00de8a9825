//! Corners as they are stored: short numbers within the room that is left for them.

use super::hull::Point;
use crate::compress::side::Side;
use crate::transmittance::Transmittance;
use crate::visibility::vertex::Vertex;

/// What corners may be moved by, so that their numbers are short: files are smaller
/// where the low bits of depths and values are 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rounding {
    side: Side,
    /// Values are multiples of this power of two, if it is not finer than `f32` is.
    grid: f64,
    /// What moving depths may change values by.
    room: f64,
}

/// The step of the `f32`s in [½, 1].
const UNIT: f64 = 1.0 / (1 << 24) as f64;

impl Rounding {
    /// Values to a grid of a 128th of ε or less, depths by what a 512th allows.
    pub(super) fn new(side: Side, epsilon: f64) -> Self {
        Self { side, grid: power_of_two(epsilon / 128.0), room: epsilon / 512.0 }
    }

    /// What both may change a value by at most, beside `f32` rounding.
    pub(super) fn spent(&self) -> f64 {
        let steps = if self.side == Side::Both { 0.5 } else { 1.0 };
        self.room + if self.grid > UNIT { self.grid * steps } else { 0.0 }
    }

    /// The stored value nearest to `value`, on its side.
    #[inline]
    pub(super) fn value(&self, value: f64) -> f32 {
        if self.grid <= UNIT {
            return self.side.round(value);
        }
        let steps = value / self.grid;
        let whole = match self.side {
            Side::Both => steps.round(),
            Side::Lighter => steps.ceil(),
            Side::Darker => steps.floor(),
        };
        // Exact: a multiple of a power of two in [0, 1].
        (whole * self.grid) as f32
    }

    /// Moves the corners of a path to short depths, none out of `depths`.
    ///
    /// A corner's value then follows one of the lines that meet there: the upper one where
    /// no value may become darker, the lower one where none may become lighter, and else
    /// their mean.
    pub(super) fn move_depths(&self, path: &mut [Point], depths: [f64; 2]) {
        let last = path.len().saturating_sub(1);
        // As it was before it was moved.
        let mut before = None;
        for index in 0..path.len() {
            let corner = path[index];
            let near = before.map_or(0.0, |near| slope(near, corner));
            let far = path.get(index + 1).map_or(0.0, |&far| slope(corner, far));
            let near_z = before.map(|near| near.z);
            before = Some(corner);
            let z = f64::from(self.depth(path, index, near_z, far - near, depths));
            let moved = z - corner.z;
            path[index].z = z;
            if (1..last).contains(&index) && near.is_finite() && far.is_finite() {
                let [near, far] = [near, far].map(|slope| corner.y + slope * moved);
                path[index].y = match self.side {
                    Side::Both => 0.5 * (near + far),
                    Side::Lighter => near.max(far),
                    Side::Darker => near.min(far),
                };
            }
        }
    }

    /// Replaces `stored` by the vertices of the path with corners `path`, whose depths are
    /// `f32`s: values do not rise, at most two corners stay at one depth, and the first and
    /// the last value are those of the path.
    pub(super) fn store<T: Transmittance>(&self, path: &[Point], stored: &mut Vec<Vertex<T>>) {
        stored.clear();
        let Some(lowest) = path.last().map(|last| last.y as f32) else { return };
        let last = path.len() - 1;
        let mut highest = 1.0_f32;
        for (index, corner) in path.iter().enumerate() {
            let is_end = index == 0 || index == last;
            let value = if is_end { corner.y as f32 } else { self.value(corner.y) };
            let value = value.max(lowest).min(highest);
            highest = value;
            let z = corner.z as f32;
            let is_third =
                stored.len() >= 2 && stored[stored.len() - 2..].iter().all(|vertex| vertex.z == z);
            if is_third {
                stored.pop();
            }
            stored.push(Vertex::new(z, T::splat(value)));
        }
    }

    /// The stored depth of a corner where the slope changes by `bend`: with as few bits
    /// as the room allows, but that of a step exactly.
    fn depth(
        &self,
        path: &[Point],
        index: usize,
        near: Option<f64>,
        bend: f64,
        depths: [f64; 2],
    ) -> f32 {
        let z = path[index].z;
        let far = path.get(index + 1);
        let before = z - near.unwrap_or(depths[0]);
        let behind = far.map_or(depths[1], |far| far.z) - z;
        let is_step = near == Some(z) || far.is_some_and(|far| far.z == z);
        let length = before.min(behind);
        if is_step || !bend.is_finite() || length <= 0.0 {
            return z as f32;
        }
        // No corner passes another.
        let is_end = near.is_none() || far.is_none();
        // To one side a depth is moved by a whole step, else by half of one.
        let steps = if is_end && self.side != Side::Both { 1.0 } else { 2.0 };
        let step = power_of_two((steps * self.room / bend.abs()).min(0.25 * length));
        let steps = z / step;
        let whole = match self.side {
            // A plateau is longer where it is the upper line of the two.
            Side::Lighter if is_end => steps.ceil(),
            Side::Darker if is_end => steps.floor(),
            _ => steps.round(),
        };
        let short = whole * step;
        let rounded = short as f32;
        if f64::from(rounded) == short {
            return rounded;
        }
        let nearest = z as f32;
        match self.side {
            Side::Lighter if is_end && f64::from(nearest) < z => nearest.next_up(),
            Side::Darker if is_end && f64::from(nearest) > z => nearest.next_down(),
            _ => nearest,
        }
    }
}

/// The slope from one corner to the next; infinite of a step.
fn slope(from: Point, to: Point) -> f64 {
    if to.z > from.z { (to.y - from.y) / (to.z - from.z) } else { f64::NEG_INFINITY }
}

/// The largest power of two that is not above `value`, a positive normal number.
fn power_of_two(value: f64) -> f64 {
    f64::from_bits(value.to_bits() & (0x7ff << 52))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_as_short_as_their_room_allows() {
        let path = [(1.0, 1.0), (1.3, 0.71), (2.7, 0.2), (2.7, 0.1), (4.4, 0.033)];
        let path = path.map(|(z, y)| Point::new(f64::from(z as f32), y));
        let mut stored: Vec<Vertex<f32>> = Vec::new();
        for side in [Side::Both, Side::Lighter, Side::Darker] {
            let rounding = Rounding::new(side, 0.0625);
            let mut moved = path;
            rounding.move_depths(&mut moved, [1.0, 5.0]);
            rounding.store(&moved, &mut stored);
            assert_eq!(stored.len(), 5);
            // Steps and ends stay; between them are multiples of a 4096th.
            assert_eq!([stored[2].z, stored[3].z], [2.7, 2.7]);
            assert_eq!([stored[0].value, stored[4].value], [1.0, 0.033]);
            for (vertex, corner) in stored.iter().zip(path).skip(1).take(3) {
                let steps = vertex.value * 4096.0;
                assert_eq!(steps, steps.round(), "{side:?}");
                let off = f64::from(vertex.value) - corner.y;
                assert!(off.abs() <= rounding.spent(), "{side:?} {off}");
            }
            let bits = |z: f32| 23 - z.to_bits().trailing_zeros().min(23);
            assert!(bits(stored[1].z) <= 13 && bits(stored[4].z) <= 12, "{stored:?}");
        }
    }

    #[test]
    fn powers_of_two_lie_below() {
        assert_eq!([0.3, 1.0, 1e-300].map(power_of_two)[..2], [0.25, 1.0]);
        assert!(power_of_two(1e-300) <= 1e-300 && power_of_two(1e-300) > 0.5e-300);
    }
}
