//! The optical depth along a ray: the integral of an extinction that is the
//! sum of overlapping, linear segments (Lokovic & Veach 2000, §3.2).

use super::compensated::{RunningSum, two_product, two_sum};
use super::exact_sum::ExactSum;
use crate::hits::hit::VolumeSegment;
use crate::transmittance::Transmittance;

/// An extinction beyond this is as good: over the smallest distance between
/// two `f32` nothing is left.
const MAX_EXTINCTION: f64 = 1e250;

/// The optical depth so far, and the segments the ray is in.
#[derive(Clone, Debug)]
pub(crate) struct OpticalDepth<T: Transmittance> {
    /// The extinction at depth z is intercept + slope · z. Both are free of
    /// rounding, so that a steep segment leaves no trace once it is over.
    extinction: Vec<Line>,
    depth: RunningSum<T>,
    segments: usize,
}

#[derive(Clone, Debug, Default)]
struct Line {
    intercept: ExactSum,
    slope: ExactSum,
}

impl Line {
    fn at(&self, z: f64) -> f64 {
        let (intercept, intercept_error) = self.intercept.value();
        let (slope, slope_error) = self.slope.value();
        let (product, product_error) = two_product(slope, z);
        let (sum, error) = two_sum(intercept, product);
        (sum + (error + product_error + intercept_error + slope_error * z)).max(0.0)
    }
}

impl<T: Transmittance> Default for OpticalDepth<T> {
    fn default() -> Self {
        Self {
            extinction: vec![Line::default(); T::CHANNELS],
            depth: RunningSum::new(0.0),
            segments: 0,
        }
    }
}

impl<T: Transmittance> OpticalDepth<T> {
    /// Back to the start of a ray.
    pub(crate) fn clear(&mut self) {
        for line in &mut self.extinction {
            line.intercept.clear();
            line.slope.clear();
        }
        self.depth = RunningSum::new(0.0);
        self.segments = 0;
    }

    /// The ray enters `segment`.
    pub(crate) fn enter(&mut self, segment: &VolumeSegment<T>) {
        self.add(segment, 1.0);
        self.segments += 1;
    }

    /// The ray leaves `segment`, which it has entered.
    pub(crate) fn leave(&mut self, segment: &VolumeSegment<T>) {
        self.add(segment, -1.0);
        self.segments -= 1;
    }

    fn add(&mut self, segment: &VolumeSegment<T>, sign: f64) {
        let near_depth = f64::from(segment.near);
        let length = f64::from(segment.far) - near_depth;
        for (channel, line) in self.extinction.iter_mut().enumerate() {
            let near = segment.near_extinction.as_ref()[channel].min(MAX_EXTINCTION);
            let far = segment.far_extinction.as_ref()[channel].min(MAX_EXTINCTION);
            line.intercept.add(sign * near);
            if near != far {
                let slope = (far - near) / length;
                let (product, error) = two_product(slope, near_depth);
                line.slope.add(sign * slope);
                line.intercept.add(-sign * product);
                line.intercept.add(-sign * error);
            }
        }
    }

    /// True if the ray is in no segment.
    pub(crate) const fn is_outside(&self) -> bool {
        self.segments == 0
    }

    /// The optical depth so far.
    pub(crate) fn value(&self) -> T::Sum {
        self.depth.value()
    }

    /// Goes on from `near` to `far`, between which no segment starts or ends.
    pub(crate) fn advance(&mut self, near: f32, far: f32) -> Stretch<T> {
        let start = self.value();
        let (near, far) = (f64::from(near), f64::from(far));
        let extinction = T::sum_from_channels(|channel| self.extinction[channel].at(near));
        let slope = T::sum_from_channels(|channel| {
            let (from, to) = (extinction.as_ref()[channel], self.extinction[channel].at(far));
            self.depth.add(channel, 0.5 * (from + to) * (far - near));
            (to - from) / (far - near)
        });
        Stretch { near, start, extinction, slope }
    }
}

/// A stretch over which the extinction is linear in every channel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stretch<T: Transmittance> {
    near: f64,
    start: T::Sum,
    extinction: T::Sum,
    slope: T::Sum,
}

impl<T: Transmittance> Stretch<T> {
    /// The optical depth at depth `z`.
    pub(crate) fn optical_depth(&self, z: f64) -> T::Sum {
        let distance = z - self.near;
        T::sum_from_channels(|channel| {
            let mean =
                self.extinction.as_ref()[channel] + 0.5 * self.slope.as_ref()[channel] * distance;
            self.start.as_ref()[channel] + mean.max(0.0) * distance
        })
    }

    /// By how much the extinction changes per unit of depth, in the channel where that is
    /// most.
    pub(crate) fn steepest(&self) -> f64 {
        self.slope.as_ref().iter().fold(0.0, |most, slope| most.max(slope.abs()))
    }

    /// The distance from `z` that a chord may reach before it can miss f =
    /// exp(−optical depth), `value` at `z`, by more than `error`.
    ///
    /// A chord of length h misses f by at most h²/8 max |f″|, and
    /// f″ = (κ² − κ′) f with the extinction κ. Where κ falls, |f″| is greatest
    /// at the near end. Where it rises, κ² f rises too, but only until
    /// κ² = 2κ′.
    pub(crate) fn chord_length(&self, channel: usize, z: f64, value: f64, error: f64) -> f64 {
        let slope = self.slope.as_ref()[channel];
        let extinction = (self.extinction.as_ref()[channel] + slope * (z - self.near)).max(0.0);
        let square = extinction * extinction;
        let reach = |curvature: f64| (8.0 * error / (curvature * value)).sqrt();
        if slope <= 0.0 {
            reach(square - slope)
        } else if square >= 2.0 * slope {
            reach(square)
        } else {
            // κ² grows along the chord, but no further than on the chord that
            // the curvature at its near end would allow.
            let far = extinction + slope * reach(square.max(slope));
            reach((far * far).max(slope).min(2.0 * slope))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn segment(near: f32, far: f32, from: f64, to: f64) -> VolumeSegment<f32> {
        VolumeSegment { near, far, near_extinction: [from], far_extinction: [to] }
    }

    #[test]
    fn overlapping_segments_add() {
        let mut depth = OpticalDepth::<f32>::default();
        let (long, short) = (segment(1.0, 5.0, 0.2, 0.6), segment(2.0, 3.0, 1.0, 0.0));
        depth.enter(&long);
        depth.advance(1.0, 2.0);
        assert!((depth.value()[0] - 0.25).abs() < 1e-16);
        depth.enter(&short);
        let both = depth.advance(2.0, 3.0);
        assert!((both.optical_depth(2.5)[0] - (0.25 + 0.1625 + 0.375)).abs() < 1e-15);
        depth.leave(&short);
        depth.advance(3.0, 5.0);
        depth.leave(&long);
        assert!(depth.is_outside());
        assert!((depth.value()[0] - 2.1).abs() < 1e-15);
    }

    #[test]
    fn a_steep_segment_far_out_keeps_its_integral() {
        // Here intercept and slope · z are 2²⁴ times the extinction.
        let near = 1000.1_f32;
        let steep = segment(near, near.next_up(), 0.0, 12_345.678);
        let mut depth = OpticalDepth::<f32>::default();
        depth.enter(&steep);
        depth.advance(near, near.next_up());
        let length = f64::from(near.next_up()) - f64::from(near);
        assert!((depth.value()[0] - 0.5 * 12_345.678 * length).abs() < 1e-15);
    }

    #[test]
    fn a_steep_segment_leaves_no_trace() {
        let mut depth = OpticalDepth::<f32>::default();
        let tiny = f32::from_bits(1);
        let steep = segment(tiny, tiny.next_up(), 1e44, 0.0);
        let mild = segment(0.0, 1e6, 1e-7, 2e-7);
        depth.enter(&mild);
        depth.advance(0.0, tiny);
        depth.enter(&steep);
        depth.advance(tiny, tiny.next_up());
        depth.leave(&steep);
        let before = depth.value()[0];
        depth.advance(tiny.next_up(), 1e6);
        assert!((depth.value()[0] - before - 0.15).abs() < 1e-16);
    }
}
