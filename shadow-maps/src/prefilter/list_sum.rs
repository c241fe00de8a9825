//! What one list takes of the light, weighed by depth.

use dsm_core::Transmittance;

use super::hat::Hat;
use super::sums::ListView;

/// A w as lists have it: places may lie beyond every fragment.
#[inline]
fn single(w: f64) -> f32 {
    (w as f32).clamp(-f32::MAX, f32::MAX)
}

/// The part of a hat above some place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    hat: Hat,
    slopes: [f64; 2],
    /// Where it begins: nothing lies between the finer level's place and this.
    low: f64,
    weight: f64,
}

impl Window {
    /// The part of `hat` above `start`.
    #[inline]
    pub(super) fn new(hat: Hat, start: f64) -> Self {
        Self { hat, slopes: hat.slopes(), low: 0.0, weight: 0.0 }.above(start)
    }

    /// The part above another place.
    #[inline]
    pub(super) fn above(self, start: f64) -> Self {
        let low = self.hat.knots[0].max(start);
        Self { low, weight: self.hat.weight(low), ..self }
    }

    /// True if it has no fragment of a list whose nearest is `nearest`.
    #[inline]
    pub(super) fn is_beyond(&self, nearest: f64) -> bool {
        self.low >= nearest || self.low >= self.hat.knots[2]
    }

    /// The light left of a list whose fragments' optical depths count as the hat weighs
    /// them. O(log fragments).
    #[inline]
    pub(super) fn product<T: Transmittance>(&self, list: &ListView<'_, T>) -> T {
        if list.w.is_empty() || self.is_beyond(list.w[0].into()) {
            return T::CLEAR;
        }
        let [_, own, after] = self.hat.knots;
        let [rise, fall] = self.slopes.map(|slope| slope as f32);
        let low = list.above(single(self.low));
        let middle = if own > self.low { list.above(single(own)) } else { low };
        let high = if after.is_finite() { list.above(single(after)) } else { [T::BLOCKED; 2] };
        let weight = self.weight as f32;
        T::from_channels(|channel| {
            let [depth, low] = low.map(|sum| sum.channel(channel));
            let (middle, high) = (middle[1].channel(channel), high[1].channel(channel));
            let sum = weight * depth + rise * (low - middle) - fall * (middle - high);
            // Rounding may leave less than nothing.
            (-sum.max(0.0)).exp()
        })
    }

    /// The fragments of a list with a weight, each with it and with whether it lies on
    /// the side of the coarser level.
    fn fragments<'a, T: Transmittance>(
        &self,
        list: &ListView<'a, T>,
    ) -> impl Iterator<Item = (f64, bool, T)> + use<'a, T> {
        let (hat, low) = (self.hat, self.low);
        let end = list.count_above(single(low));
        let start = list.count_above(single(hat.knots[2]));
        let fragments = list.w[start..end].iter().zip(&list.opacities[start..end]);
        fragments.map(move |(&w, &opacity)| {
            let w = f64::from(w);
            (hat.weight(w), w > hat.knots[1], opacity)
        })
    }

    /// The sum of a list's opacities, weighed. O(fragments of the hat).
    pub(super) fn sum<T: Transmittance>(&self, list: &ListView<'_, T>) -> T::Sum {
        let mut sum = T::BLOCKED.to_sum();
        for (weight, _, opacity) in self.fragments(list) {
            for (sum, one) in sum.as_mut().iter_mut().zip(opacity.to_sum().as_ref()) {
                *sum += weight * one;
            }
        }
        sum
    }

    /// The largest of a list's opacities, weighed: of the side of the finer level, and of
    /// that of the coarser. O(fragments of the hat).
    pub(super) fn largest<T: Transmittance>(&self, list: &ListView<'_, T>) -> [T::Sum; 2] {
        let mut largest = [T::BLOCKED.to_sum(); 2];
        for (weight, is_coarser, opacity) in self.fragments(list) {
            let side = largest[usize::from(is_coarser)].as_mut().iter_mut();
            for (most, one) in side.zip(opacity.to_sum().as_ref()) {
                *most = most.max(weight * one);
            }
        }
        largest
    }
}
