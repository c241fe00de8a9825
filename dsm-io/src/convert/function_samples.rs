//! Visibility functions as deep samples: steps as points, ramps as volumes.

use std::marker::PhantomData;

use deep_exr::{DeepRows, DeepSample, SampleType};
use dsm_core::detail::{SumVertex, VisibilityView};
use dsm_core::{Transmittance, Vertex};

use super::exponential::{keeps_to_chord, largest_difference, longest_fall};

/// What rounding to 32-bit, and to 16-bit, opacities may add to the error of
/// ramps.
const ROUNDING: f64 = 1.2e-7;
const HALF_ROUNDING: f64 = 1.0 / 2048.0;

/// Turns visibility functions into samples.
///
/// Each opacity is taken against what the samples in front of it let through
/// as they were rounded, not against the function: so that rounding never
/// adds up, however many samples there are.
///
/// A function of n vertices gets at most about n + 0.75 / √error samples a
/// channel: a volume falls by a factor e^(−L) with L² ≈ 8 error / V, and its
/// √V by √(2 error).
pub(super) struct FunctionSampler<T: Transmittance> {
    sample_type: SampleType,
    error: f64,
    /// What the samples up to here let through.
    left: [f64; 3],
    worst: f64,
    channels: PhantomData<T>,
}

impl<T: Transmittance> FunctionSampler<T> {
    /// Samples of this type, volumes within `error` of ramps.
    pub(super) fn new(sample_type: SampleType, error: f64) -> Self {
        let rounding = match sample_type {
            SampleType::Float => ROUNDING,
            SampleType::Half => HALF_ROUNDING.min(error / 2.0),
        };
        let error = error - rounding;
        Self { sample_type, error, left: [1.0; 3], worst: 0.0, channels: PhantomData }
    }

    /// The largest difference so far between a function and its samples, at
    /// any depth, on both sides of steps.
    pub(super) fn worst(&self) -> f64 {
        self.worst
    }

    /// Adds the function's samples to `rows`, front to back and without
    /// overlaps.
    pub(super) fn append(&mut self, function: VisibilityView<'_, T>, rows: &mut DeepRows) {
        self.left = [1.0; 3];
        let mut vertices = function.vertices().map(|v| Vertex::new(v.z, v.value.to_sum()));
        let Some(mut near) = vertices.next() else { return };
        for far in vertices {
            if far.value == near.value {
                // Nothing is in the way.
            } else if far.z == near.z {
                self.point(far.z, &far.value, &far.value, rows);
            } else {
                self.ramp(near, far, rows);
            }
            near = far;
        }
    }

    /// Cuts a ramp into volumes that keep to it.
    fn ramp(&mut self, from: SumVertex<T>, to: SumVertex<T>, rows: &mut DeepRows) {
        let mut near = from;
        while near.z < to.z {
            // No volume reaches 0: what is on the way there and dark enough
            // ends at a point.
            let aims = T::sum_from_channels(|channel| {
                let (value, end) = (near.value.as_ref()[channel], to.value.as_ref()[channel]);
                if end == 0.0 && value <= self.error { 0.0 } else { self.left[channel] }
            });
            self.point(near.z, &aims, &near.value, rows);
            let far = self.piece_end(&near, &to);
            self.volume(&near, &far, rows);
            near = far;
        }
        let aims = T::sum_from_channels(|channel| match to.value.as_ref()[channel] {
            0.0 => 0.0,
            _ => self.left[channel],
        });
        self.point(to.z, &aims, &to.value, rows);
    }

    /// How far a volume that begins at `near` may go towards `to`.
    fn piece_end(&self, near: &SumVertex<T>, to: &SumVertex<T>) -> SumVertex<T> {
        let mut share = 1.0_f64;
        for channel in 0..T::CHANNELS {
            let (value, end) = (near.value.as_ref()[channel], to.value.as_ref()[channel]);
            let distance = self.error / value;
            if value == end
                || self.left[channel] == 0.0
                || keeps_to_chord((value / end).ln(), distance)
            {
                continue;
            }
            share = share.min(value * -(-longest_fall(distance)).exp_m1() / (value - end));
        }
        if share >= 1.0 {
            return *to;
        }
        let (front, back) = (f64::from(near.z), f64::from(to.z));
        let z = front + (back - front) * share;
        let below = if f64::from(z as f32) > z { (z as f32).next_down() } else { z as f32 };
        // Between neighbouring depths there is nothing to miss.
        let z = below.max(near.z.next_up());
        if z >= to.z {
            return *to;
        }
        let share = (f64::from(z) - front) / (back - front);
        let value = T::sum_from_channels(|channel| {
            let value = near.value.as_ref()[channel];
            value + (to.value.as_ref()[channel] - value) * share
        });
        Vertex::new(z, value)
    }

    /// A point behind which `aims` is to be left, where the function is
    /// `value`.
    fn point(&mut self, z: f32, aims: &T::Sum, value: &T::Sum, rows: &mut DeepRows) {
        let alpha = self.opacities(aims, |aim| aim == 0.0);
        self.push(z, z, alpha, rows);
        for channel in 0..T::CHANNELS {
            self.worst = self.worst.max((self.left[channel] - value.as_ref()[channel]).abs());
        }
    }

    fn volume(&mut self, near: &SumVertex<T>, far: &SumVertex<T>, rows: &mut DeepRows) {
        // An opaque volume would block the light where it begins.
        let alpha = self.opacities(&far.value, |_| false);
        let before = self.left;
        self.push(near.z, far.z, alpha, rows);
        let ends = near.value.as_ref().iter().zip(far.value.as_ref());
        let curves = before.iter().zip(&self.left);
        for ((&chord_near, &chord_far), (&near_left, &far_left)) in ends.zip(curves) {
            let (chord, curve) = ([chord_near, chord_far], [near_left, far_left]);
            let difference = if near.z.next_up() == far.z {
                (chord[0] - curve[0]).abs().max((chord[1] - curve[1]).abs())
            } else {
                largest_difference(chord, curve)
            };
            self.worst = self.worst.max(difference);
        }
    }

    /// What has to be stopped for `aims` to be left. Only where `may_close`
    /// is an opacity 1.
    fn opacities(&self, aims: &T::Sum, may_close: impl Fn(f64) -> bool) -> [f32; 3] {
        let mut alpha = [0.0; 3];
        for (channel, &aim) in aims.as_ref().iter().enumerate() {
            let left = self.left[channel];
            if aim < left {
                let stopped = (left - aim) / left;
                let highest = if may_close(aim) { 1.0 } else { 1.0 - f64::EPSILON };
                alpha[channel] = self.sample_type.round(stopped.min(highest));
            }
        }
        alpha
    }

    fn push(&mut self, z: f32, z_back: f32, alpha: [f32; 3], rows: &mut DeepRows) {
        if alpha == [0.0; 3] {
            return;
        }
        for (left, alpha) in self.left.iter_mut().zip(alpha) {
            *left *= 1.0 - f64::from(alpha);
        }
        rows.push(DeepSample { z, z_back, alpha });
    }
}
