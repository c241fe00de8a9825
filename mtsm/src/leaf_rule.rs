//! The light that a shadow ray loses at the layers of a pixel (Xie, Tabellion & Pearce
//! 2007, §5.2 and §6.1).

use dsm_core::{SurfaceHit, Transmittance};

use crate::layer::LayerRun;

/// The rule by which a layer that counts several samples is split.
///
/// ```
/// use mtsm::detail::LeafRule;
///
/// assert_eq!(LeafRule::default(), LeafRule::Ratio);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum LeafRule {
    /// Every sample leaves the same share of what reaches it,
    /// (vᵢ / vᵢ₋₁)^(1 / countᵢ), whatever the ray has met before. This is what
    /// single hairs and leaves do.
    #[default]
    Ratio,
    /// Every sample takes dvᵢ = (vᵢ₋₁ − vᵢ) / countᵢ off the ray's light, down to
    /// 0: the paper's equation 3. Rays that miss the first samples of a pixel
    /// stay too light, since dvᵢ shrinks with the light left along the pixel's
    /// own ray.
    Subtract,
}

/// The part of a ray within a pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Interval {
    enter: f64,
    leave: f64,
    far: f64,
    near: f64,
    threshold: f64,
}

impl Interval {
    /// w from `enter` up to `leave`; samples reach `threshold` to either side in
    /// depth.
    pub(crate) fn new(enter: f64, leave: f64, threshold: f64) -> Self {
        // The only divides of a ray's walk.
        Self { enter, leave, far: enter.recip(), near: leave.recip(), threshold }
    }

    /// Whether a sample at depth `z` is met. Without a threshold the interval is
    /// half-open in w, so that neighbouring pixels share no sample. Monotone on
    /// either side.
    fn is_nearer(&self, z: f64) -> bool {
        if self.threshold > 0.0 { z + self.threshold < self.near } else { z.recip() >= self.leave }
    }

    fn is_farther(&self, z: f64) -> bool {
        if self.threshold > 0.0 { z - self.threshold > self.far } else { z.recip() < self.enter }
    }

    pub(crate) fn meets(&self, z: f64) -> bool {
        !self.is_nearer(z) && !self.is_farther(z)
    }

    /// How many of the samples of a layer are met. O(1), but O(log count) where
    /// rounding moves samples.
    fn count(&self, samples: &Samples) -> u32 {
        let Samples { start, end, count } = *samples;
        // One less than all numbers, so that there is one behind the last.
        let samples = &Samples { count: count.min(u32::MAX - 1), ..*samples };
        if count == 1 || start >= end {
            return if self.meets(end) { count } else { 0 };
        }
        if self.is_nearer(end) {
            return 0;
        }
        let first = samples.first_that(self.near - self.threshold, |z| !self.is_nearer(z));
        let past = samples.first_that(self.far + self.threshold, |z| self.is_farther(z));
        past.saturating_sub(first)
    }
}

/// The estimated samples of a layer: depths start + k (end − start) / count for
/// k = 1 … count, the last of which is the layer itself.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Samples {
    pub(crate) start: f64,
    pub(crate) end: f64,
    pub(crate) count: u32,
}

impl Samples {
    /// The depth of sample `k`.
    pub(crate) fn depth(&self, k: u32) -> f64 {
        if k == self.count {
            self.end
        } else {
            self.start + f64::from(k) * (self.end - self.start) / f64::from(self.count)
        }
    }

    /// The first k in 1 … count + 1 whose sample `is` what it is searched for,
    /// which holds for all behind it, too: near depth `z`, but for rounding.
    fn first_that(&self, z: f64, is: impl Fn(f64) -> bool) -> u32 {
        let per_sample = (self.end - self.start) / f64::from(self.count);
        // Saturates; NaN is 0.
        let guess = ((z - self.start) / per_sample) as u32;
        let guess = guess.clamp(1, self.count);
        let is = |k: u32| k > self.count || (k > 0 && is(self.depth(k)));
        for k in [guess, guess + 1] {
            if is(k) && !is(k - 1) {
                return k;
            }
        }
        // Where depths are too close for numbers to tell them apart.
        let (mut before, mut found) = (0, self.count + 1);
        while found - before > 1 {
            let middle = before + (found - before) / 2;
            if is(middle) { found = middle } else { before = middle }
        }
        found
    }
}

/// The light of a ray on its way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RayLight<T: Transmittance> {
    pub(crate) left: T::Sum,
    rule: LeafRule,
    /// What a run ends with instead of 0 where its last layer counts several
    /// samples.
    floor: f64,
}

impl<T: Transmittance> RayLight<T> {
    pub(crate) fn new(rule: LeafRule, floor: f64) -> Self {
        Self { left: T::CLEAR.to_sum(), rule, floor }
    }

    /// Whether less than `least` is left in every channel.
    pub(crate) fn is_below(&self, least: f64) -> bool {
        self.left.as_ref().iter().all(|&left| left < least)
    }

    /// Meets `hits` samples of a layer of `count` that falls from `before` to
    /// `after`.
    fn fall(&mut self, before: T, after: T, hits: u32, count: u32) {
        if hits == 0 {
            return;
        }
        let (rule, floor) = (self.rule, self.floor);
        for (channel, left) in self.left.as_mut().iter_mut().enumerate() {
            let [before, after] = [before, after].map(|value| f64::from(value.channel(channel)));
            // Flat in this channel: its samples take nothing.
            if after >= before {
                continue;
            }
            match rule {
                LeafRule::Subtract => {
                    let share = f64::from(hits) / f64::from(count);
                    *left = (*left - (before - after) * share).max(0.0);
                }
                LeafRule::Ratio => *left *= ratio(before, after, hits, count, floor),
            }
        }
    }

    /// Meets those layers of a run that lie in the interval.
    pub(crate) fn pass_run(&mut self, run: LayerRun<'_, T>, interval: &Interval) {
        self.pass_run_by(run, |samples| interval.count(samples));
    }

    /// The same one sample after the other.
    pub(crate) fn pass_run_naively(&mut self, run: LayerRun<'_, T>, interval: &Interval) {
        self.pass_run_by(run, |samples| {
            (1..=samples.count).filter(|&k| interval.meets(samples.depth(k))).count() as u32
        });
    }

    /// From the receiver towards the light: back to front.
    fn pass_run_by(&mut self, run: LayerRun<'_, T>, count_hits: impl Fn(&Samples) -> u32) {
        let depths = run.function().depths();
        for index in (1..run.len()).rev() {
            let count = run.counts()[index];
            if count > 0 {
                let [start, end] = [depths[index - 1], depths[index]].map(f64::from);
                let hits = count_hits(&Samples { start, end, count });
                if hits > 0 {
                    let value = |layer| run.function().value(layer);
                    self.fall(value(index - 1), value(index), hits, count);
                }
            }
        }
    }

    /// Meets those depth layers of a pixel that lie in the interval. What is
    /// subtracted is what they take along the pixel's own ray, whose light is set
    /// to 1 again where it has come to 0.
    pub(crate) fn pass_layers(
        &mut self,
        layers: impl Iterator<Item = SurfaceHit<T>>,
        interval: &Interval,
    ) {
        let mut along = T::CLEAR;
        for layer in layers {
            let past = layer.transmittance();
            let behind = T::from_channels(|channel| along.channel(channel) * past.channel(channel));
            if interval.meets(f64::from(layer.depth)) {
                match self.rule {
                    LeafRule::Subtract => self.fall(along, behind, 1, 1),
                    LeafRule::Ratio => self.fall(T::CLEAR, past, 1, 1),
                }
            }
            along = if behind == T::BLOCKED { T::CLEAR } else { behind };
        }
    }
}

/// The share that `hits` of a layer's `count` samples leave, if each leaves the
/// same. `floor` stands for the 0 that a run ends with: hardly any light was
/// left there, and of several samples that does not make each opaque.
fn ratio(before: f64, after: f64, hits: u32, count: u32, floor: f64) -> f64 {
    if count == 1 {
        return after / before;
    }
    let ratio = after.max(floor.min(0.5 * before)) / before;
    if hits == count { ratio } else { ratio.powf(f64::from(hits) / f64::from(count)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counting_agrees_with_trying_every_sample() {
        let mut tried = 0;
        for (start, end, count) in
            [(1.0, 4.0, 3), (1.0, 4.0, 7), (2.0, 2.0, 5), (0.0, 0.5, 4), (1.0, 1.0 + 1e-7, 9)]
        {
            let samples = Samples { start, end, count };
            for (enter, length) in
                (1..40).flat_map(|enter| (0..12).map(move |length| (enter, length)))
            {
                let enter = f64::from(enter) / 16.0;
                let leave =
                    if length == 11 { f64::INFINITY } else { enter + f64::from(length) / 16.0 };
                for threshold in [0.0, 0.25, 1.0] {
                    let interval = Interval::new(enter, leave, threshold);
                    let met = (1..=count).filter(|&k| interval.meets(samples.depth(k))).count();
                    assert_eq!(interval.count(&samples) as usize, met, "{samples:?} {interval:?}");
                    tried += usize::from(met > 0 && met < count as usize);
                }
            }
        }
        assert!(tried > 500, "{tried}");
    }

    #[test]
    fn counts_without_sense_take_no_time() {
        for count in [u32::MAX, u32::MAX - 1, 1 << 31] {
            for (start, end) in [(1.0, 1.000_000_1), (0.0, 1e-40), (0.5, 3e38)] {
                for threshold in [0.0, 1e9, 1e300] {
                    for (enter, leave) in [(0.0, f64::INFINITY), (0.5, 2.0), (1.0, 1.0)] {
                        let samples = Samples { start, end, count };
                        let met = Interval::new(enter, leave, threshold).count(&samples);
                        assert!(met <= count);
                    }
                }
            }
        }
    }

    #[test]
    fn neighbours_share_no_sample() {
        let samples = Samples { start: 1.0, end: 2.0, count: 1 };
        let met = |enter, leave| Interval::new(enter, leave, 0.0).count(&samples);
        assert_eq!([met(0.25, 0.5), met(0.5, 0.75)], [0, 1]);
        let several = Samples { start: 1.0, end: 4.0, count: 3 };
        let met = |enter, leave| Interval::new(enter, leave, 0.0).count(&several);
        assert_eq!([met(0.125, 0.25), met(0.25, 0.5), met(0.5, 1.0)], [0, 2, 1]);
    }

    #[test]
    fn the_rules_are_those_of_the_paper_and_of_hairs() {
        let left = |rule, hits| {
            let mut light = RayLight::<f32>::new(rule, 0.0025);
            light.fall(0.5, 0.125, hits, 2);
            light.left[0]
        };
        assert_eq!([1, 2].map(|hits| left(LeafRule::Subtract, hits)), [0.8125, 0.625]);
        assert_eq!([1, 2].map(|hits| left(LeafRule::Ratio, hits)), [0.5, 0.25]);
    }

    #[test]
    fn subtraction_stops_at_nothing() {
        let mut light = RayLight::<f32>::new(LeafRule::Subtract, 0.0);
        (0..3).for_each(|_| light.fall(1.0, 0.5, 1, 1));
        assert_eq!(light.left, [0.0]);
    }

    #[test]
    fn one_opaque_sample_blocks_and_one_of_several_dark_ones_does_not() {
        let left = |count| {
            let mut light = RayLight::<f32>::new(LeafRule::Ratio, 0.0025);
            light.fall(0.5, 0.0, 1, count);
            light.left[0]
        };
        assert_eq!(left(1), 0.0);
        assert!((left(4) - 0.005_f64.powf(0.25)).abs() < 1e-12);
    }
}
