//! The tube around V that V′ is drawn in.

use super::slope_window::{SlopeWindow, Target, larger, smaller};
use crate::transmittance::Transmittance;
use crate::visibility::vertex::{SumVertex, Vertex};

/// The largest error of a sum from the order of its terms: as much as V may rise,
/// leave [0, 1] or miss the announced end.
pub(super) const SUM_ROUNDING: f64 = 1.0 / (1_u64 << 40) as f64;

/// The margin by which the tube is narrower than ε: an end that is rounded to
/// `f32`, or moved into the tube first, is off by 2⁻²⁴ at most, V(∞) by 2⁻²⁵, and a
/// lookup rounds by 2⁻²⁵.
const MARGIN: f64 = 1.0 / (1 << 22) as f64;

/// Half a unit in the last place of the `f32`s in [½, 1].
const HALF_UNIT: f64 = 1.0 / (1 << 25) as f64;

/// The tube around V in which V′ is drawn, and the rounding that keeps it
/// there: every value that is written is an `f32`, not above the last one and
/// not below the floor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tube<T: Transmittance> {
    target: Target<T>,
    /// The largest distance below the next vertex at which a segment may end: less
    /// than `target.down`, so that rounding doesn't leave the tube.
    end_down: f64,
}

impl<T: Transmittance> Tube<T> {
    /// [max(V − ε, `last`), V + ε].
    pub(super) fn above(last: T, epsilon: f64) -> Self {
        let down = epsilon - MARGIN;
        let target = Target { down, up: down, floor: last.to_sum() };
        Self { target, end_down: down - HALF_UNIT }
    }

    /// [V, V + ε].
    pub(super) fn not_below(epsilon: f64) -> Self {
        let floor = T::BLOCKED.to_sum();
        let target = Target { down: 0.0, up: epsilon - MARGIN, floor };
        Self { target, end_down: 0.0 }
    }

    /// The `f32`s nearest to `value` that V′ may fall to from `highest`.
    #[inline(always)]
    pub(super) fn round(&self, value: &T::Sum, highest: &T::Sum) -> T {
        T::from_channels(|channel| {
            let raised = larger(value.as_ref()[channel], self.target.floor.as_ref()[channel]);
            smaller(raised, highest.as_ref()[channel]) as f32
        })
    }

    /// Writes `origin` and starts a segment there. No vertex from now on lies
    /// above `next`.
    #[inline(always)]
    pub(super) fn start(
        &self,
        origin: Vertex<T>,
        next: &T::Sum,
        emit: &mut impl FnMut(Vertex<T>),
    ) -> SlopeWindow<T> {
        emit(origin);
        let origin = Vertex::new(origin.z, origin.value.to_sum());
        let mut window = SlopeWindow::from_origin(origin, &self.target);
        window.never_rise_above(next, SUM_ROUNDING);
        window
    }

    /// Ends a segment at the last vertex it passed and starts the next.
    /// `next` is the value of the vertex that it couldn't pass.
    #[inline(always)]
    pub(super) fn turn(
        &self,
        window: &SlopeWindow<T>,
        next: &T::Sum,
        emit: &mut impl FnMut(Vertex<T>),
    ) -> SlopeWindow<T> {
        let (origin, end) = (window.origin(), window.end());
        // The next segment waits for the end: all else is settled before it.
        let value = T::from_channels(|channel| {
            let highest = origin.value.as_ref()[channel];
            let lowest = next.as_ref()[channel] - self.end_down;
            let lowest = larger(lowest, self.target.floor.as_ref()[channel]);
            let lowest = smaller(lowest, highest);
            // No lower bound asks for a rise, so that going straight on is
            // within the window if its middle rises.
            let end = smaller(end.value.as_ref()[channel], highest);
            larger(end, lowest) as f32
        });
        self.start(Vertex::new(end.z, value), next, emit)
    }

    /// Goes to `vertex` at the origin's own depth: a step, unless the origin
    /// will do in every channel.
    #[inline(always)]
    pub(super) fn step(
        &self,
        window: &SlopeWindow<T>,
        vertex: &SumVertex<T>,
        emit: &mut impl FnMut(Vertex<T>),
    ) -> SlopeWindow<T> {
        let origin = window.origin();
        // What rounding did to the origin is no reason for a step.
        let up = self.target.up + 2.0 * HALF_UNIT;
        let mut both = origin.value.as_ref().iter().zip(vertex.value.as_ref());
        if both.all(|(&from, &to)| from <= to + up) {
            return *window;
        }
        // One channel falls for certain, and needn't wait for the origin.
        let highest = if T::CHANNELS == 1 { T::CLEAR.to_sum() } else { origin.value };
        let value = self.round(&vertex.value, &highest);
        self.start(Vertex::new(vertex.z, value), &vertex.value, emit)
    }

    /// Ends V′ at the depth of `vertex` with the value `last`.
    pub(super) fn finish(
        &self,
        mut window: SlopeWindow<T>,
        vertex: &SumVertex<T>,
        last: T,
        emit: &mut impl FnMut(Vertex<T>),
    ) {
        let end = Vertex::new(vertex.z, last.to_sum());
        if window.is_open() && !window.admits(&end) {
            window = self.turn(&window, &vertex.value, emit);
        }
        if window.origin().value != end.value {
            emit(Vertex::new(vertex.z, last));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The ends of segments whose last slope runs along the lower side of
    /// `tube` to `down` above `bottom`; beside it what they may not be below.
    fn ends_on_the_lower_side(tube: &Tube<f32>, bottom: f64, down: f64) -> Vec<(f32, f64)> {
        let (origin, up) = (Vertex::new(0.0, 1.0), tube.target.up);
        let mut ends = Vec::new();
        for step in 1..2000_u16 {
            let last = 1.0 + f32::from(step) / 7.0;
            let lowest = bottom + (1.0 - bottom) * f64::from(step) / 4000.0;
            // Just under the highest line that goes there.
            let middle = (1.0 - lowest).mul_add(-0.5, 1.0) - up;
            let vertices = [(0.5 * last, middle + 1e-12), (last, lowest + down)];
            let mut window = tube.start(origin, &[1.0], &mut |_| {});
            if vertices.iter().all(|&(z, value)| window.narrow_by(&Vertex::new(z, [value]))) {
                let mut end = None;
                tube.turn(&window, &[lowest + down], &mut |vertex| end = Some(vertex));
                ends.extend(end.map(|end| (end.value, lowest)));
            }
        }
        assert!(ends.len() > 1000, "only {} segments ended", ends.len());
        ends
    }

    #[test]
    fn rounding_does_not_leave_the_tube() {
        let tube = Tube::above(0.0, 0.1);
        for (end, lowest) in ends_on_the_lower_side(&tube, 0.01, tube.target.down) {
            assert!(f64::from(end) >= lowest, "{end} is below {lowest}");
        }
        for (end, value) in ends_on_the_lower_side(&Tube::not_below(0.1), 0.01, 0.0) {
            assert!(end >= value as f32, "{end} is below {value}");
        }
    }

    #[test]
    fn rounding_does_not_go_below_the_floor() {
        let mut below = 0;
        for (last, from) in [(0.0, 0.7), (0.3, 0.9)] {
            let (tube, floor) = (Tube::<f32>::above(last, 0.1), f64::from(last));
            for step in 1..2000_u16 {
                let z = f32::from(step) / 7.0;
                let mut window = tube.start(Vertex::new(0.0, from), &[1.0], &mut |_| {});
                // The highest line to the floor, and what the floor allows.
                let middle = 0.5 * (f64::from(from) + floor) - tube.target.up;
                let vertices = [(0.5 * z, middle), (z, floor + 0.01)];
                if !vertices.iter().all(|&(z, value)| window.narrow_by(&Vertex::new(z, [value]))) {
                    continue;
                }
                below += usize::from(window.end().value[0] < floor);
                let mut end = None;
                tube.turn(&window, &[floor + 0.01], &mut |vertex| end = Some(vertex.value));
                assert!(end >= Some(last), "{end:?} is below {last}");
            }
        }
        assert!(below > 0, "no end had to be raised");
    }
}
