//! The error that stored functions have.

/// The error of stored visibility functions against what they stand for.
///
/// ```
/// use dsm_io::AchievedError;
///
/// let measured = AchievedError::enclosing(0.004, 0.001);
/// assert!(measured.is_within(0.01) && !measured.is_within(0.001));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AchievedError {
    /// The largest |V′(z) − V(z)| of all pixels, depths and channels.
    pub max: f32,
    /// The mean over all pixels of a pixel's error, as whoever compressed it
    /// measured that; at most `max`.
    pub mean: f32,
}

impl AchievedError {
    /// No error at all.
    pub const NONE: Self = Self { max: 0.0, mean: 0.0 };

    /// Slack of `max` over a stated tolerance: the chord error that curved
    /// stretches have at tolerance 0 (5e-7), and the rounding of values near
    /// 1 to `f32`.
    pub const SLACK: f32 = 1e-6;

    /// An error that was measured or bounded in `f64`, neither of its numbers
    /// rounded down.
    #[must_use]
    pub fn enclosing(max: f64, mean: f64) -> Self {
        let up = |error: f64| {
            let nearest = error as f32;
            let up = if f64::from(nearest) < error { nearest.next_up() } else { nearest };
            up.min(1.0)
        };
        Self { max: up(max), mean: up(mean.min(max)) }
    }

    /// True if the error keeps to a stated tolerance.
    #[must_use]
    pub fn is_within(self, tolerance: f32) -> bool {
        self.max <= tolerance + Self::SLACK
    }

    /// Which rule the error breaks, if any.
    pub(crate) fn broken_rule(self) -> Option<&'static str> {
        let ordered = 0.0 <= self.mean && self.mean <= self.max && self.max <= 1.0;
        (!ordered).then_some("errors must lie in [0, 1], the mean not above the largest")
    }

    /// The error of parts with these numbers of pixels, in `f64` in the order
    /// of the parts.
    pub(crate) fn of_parts(parts: impl IntoIterator<Item = (Self, u64)>) -> Self {
        let (mut max, mut sum, mut pixels) = (0.0_f32, 0.0_f64, 0_u64);
        for (error, count) in parts {
            max = max.max(error.max);
            sum += f64::from(error.mean) * count as f64;
            pixels += count;
        }
        let mean = (sum / pixels.max(1) as f64) as f32;
        // The sum's rounding can lift it by a hair.
        Self { max, mean: mean.min(max) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measured_errors_are_not_rounded_down() {
        for max in [0.0, 1e-50, 0.1, 0.02_f32.into(), 1.0, 1.0 + 1e-12] {
            let error = AchievedError::enclosing(max, 2.0 * max);
            assert!(f64::from(error.max) >= f64::min(max, 1.0) && error.broken_rule().is_none());
            assert!(f64::from(error.max) <= max * (1.0 + 1e-6) + f64::from(f32::from_bits(1)));
            assert_eq!(error.mean, error.max);
        }
    }
}
