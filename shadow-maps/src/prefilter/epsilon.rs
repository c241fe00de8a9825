//! How near in depth fragments become one.

use dsm_core::Error;
use dsm_core::detail::Result;
use serde::{Deserialize, Serialize};

/// The ε-interval of a level within which fragments are merged (Selgrad et al. 2014,
/// §4.2 and §6).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Epsilon {
    /// So many widths of the level's filter at the nearest fragment's depth: a length in
    /// scene units. The paper has 2.
    Widths(f32),
    /// A share of the interval in 1 / depth for which the level is meant: what its filter
    /// is wide, over the light's width.
    Interval(f32),
}

impl Epsilon {
    /// The paper's.
    pub const PAPER: Self = Self::Widths(2.0);

    /// What is nearest to traced rays where lights are 0.03 to 0.3 of their distance wide.
    pub const INTERVAL: Self = Self::Interval(0.6);

    /// What its number cannot be, if it is that.
    pub(super) fn broken_rule(self) -> Option<&'static str> {
        let (Self::Widths(number) | Self::Interval(number)) = self;
        let is_length = (0.0..f32::INFINITY).contains(&number);
        (!is_length).then_some("epsilon must be finite and not negative")
    }

    /// The interval of a level.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] unless it is finite and not negative.
    pub(super) fn reach(self, width: f64, texel: f64, light: f64) -> Result<Reach> {
        let (Self::Widths(number) | Self::Interval(number)) = self;
        if !(0.0..f32::INFINITY).contains(&number) {
            let reason = "it must be finite and not negative";
            return Err(Error::Setting { setting: "epsilon", reason });
        }
        // How wide the level's filter is at depth 1.
        let filter = width * texel;
        Ok(match self {
            Self::Interval(share) if light > 0.0 => {
                Reach { fall: f64::from(share) * filter / light, ratio: 1.0 }
            }
            // A point has no interval.
            Self::Interval(_) => Self::PAPER.reach(width, texel, light)?,
            Self::Widths(widths) => {
                Reach { fall: 0.0, ratio: (1.0 + f64::from(widths) * filter).recip() }
            }
        })
    }
}

impl Default for Epsilon {
    fn default() -> Self {
        Self::INTERVAL
    }
}

/// Where the interval that begins at a fragment ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reach {
    /// By how much w falls.
    fall: f64,
    /// What is left of w.
    ratio: f64,
}

impl Reach {
    /// Equal depths alone.
    #[cfg(test)]
    pub(super) const NONE: Self = Self { fall: 0.0, ratio: 1.0 };

    /// The least w that is merged with `nearest`.
    #[inline]
    pub(super) fn end(self, nearest: f32) -> f64 {
        f64::from(nearest) * self.ratio - self.fall
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_what_they_say() {
        // A filter of 4 texels, each 0.001 wide at depth 1: 0.02 wide at depth 5.
        let paper = Epsilon::PAPER.reach(4.0, 0.001, 0.5).unwrap();
        assert!((paper.end(0.2).recip() - (5.0 + 2.0 * 0.02)).abs() < 1e-6);
        let own = Epsilon::Interval(0.5).reach(4.0, 0.001, 0.5).unwrap();
        assert!((f64::from(0.2_f32) - own.end(0.2) - 0.5 * 0.004 / 0.5).abs() < 1e-12);
        let point = Epsilon::Interval(0.5).reach(4.0, 0.001, 0.0).unwrap();
        assert_eq!(point, paper);
        for bad in [-1.0, f32::NAN, f32::INFINITY] {
            assert!(Epsilon::Widths(bad).reach(1.0, 1.0, 1.0).is_err());
            assert!(Epsilon::Interval(bad).reach(1.0, 1.0, 1.0).is_err());
        }
    }
}
