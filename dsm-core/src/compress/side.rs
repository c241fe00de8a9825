//! The side of a function on which what stands for it keeps.

use serde::{Deserialize, Serialize};

/// The side of V on which V′ keeps: how the tolerance is used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// Within ε above and below.
    #[default]
    Both,
    /// Never darker: V ≤ V′ ≤ V + ε, so that nothing shadows itself by what
    /// compression added.
    Lighter,
    /// Never lighter: V − ε ≤ V′ ≤ V, so that nothing leaks.
    Darker,
}

impl Side {
    /// The shares of ε below and above V.
    pub(crate) const fn shares(self) -> [f64; 2] {
        match self {
            Self::Both => [1.0, 1.0],
            Self::Lighter => [0.0, 1.0],
            Self::Darker => [1.0, 0.0],
        }
    }

    /// The `f32` nearest to `value` that is not on the wrong side of it.
    #[inline]
    pub(crate) fn round(self, value: f64) -> f32 {
        let nearest = value as f32;
        match self {
            Self::Lighter if f64::from(nearest) < value => nearest.next_up(),
            Self::Darker if f64::from(nearest) > value => nearest.next_down(),
            _ => nearest,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_rounded_to_their_side() {
        for value in [0.1, 0.3, 1.0 / 3.0, 0.7, 1e-30, 1e-60] {
            let rounded = |side: Side| f64::from(side.round(value));
            assert!(rounded(Side::Lighter) > value && rounded(Side::Darker) < value);
            assert_eq!(Side::Lighter.round(value), Side::Darker.round(value).next_up());
            assert!(
                rounded(Side::Both) == rounded(Side::Lighter)
                    || rounded(Side::Both) == rounded(Side::Darker)
            );
        }
        for value in [0.0, 0.5, 1.0] {
            for side in [Side::Both, Side::Lighter, Side::Darker] {
                assert_eq!(f64::from(side.round(value)), value);
            }
        }
    }
}
