//! The error bound of a map, and its budget among the stages of a bake.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

/// The L∞ error bound of a visibility function: |V′(z) − V(z)| ≤ ε at both
/// sides of every step, for every channel. In [0, 1).
///
/// ```
/// use dsm_core::Tolerance;
///
/// let tolerance = Tolerance::new(0.02)?;
/// assert_eq!(tolerance.epsilon(), 0.02);
/// assert!(Tolerance::new(1.0).is_err());
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd, Serialize, Deserialize)]
#[serde(try_from = "f32", into = "f32")]
pub struct Tolerance(f32);

impl Tolerance {
    /// No compression: every vertex is kept.
    pub const EXACT: Self = Self(0.0);

    /// The smallest chord error that is required of curved stretches, so that a
    /// tolerance of 0 stays finite with volumes.
    pub const CHORD_FLOOR: f64 = 5e-7;

    /// A bound of `epsilon`.
    ///
    /// # Errors
    ///
    /// [`Error::Tolerance`] outside [0, 1) and for NaN.
    pub fn new(epsilon: f32) -> Result<Self> {
        if (0.0..1.0).contains(&epsilon) {
            Ok(Self(epsilon))
        } else {
            Err(Error::Tolerance(epsilon))
        }
    }

    /// The tolerance of a map with `samples` samples a pixel: 0.25/√N, half
    /// of the noise that N samples can have (Lokovic & Veach 2000, §4).
    #[must_use]
    pub fn for_samples(samples: u32) -> Self {
        Self::for_effective_samples(samples.into())
    }

    /// The tolerance under a filter wider than a pixel, which averages more than
    /// the pixel's own samples: N = 1/Σ w², its samples a pixel times
    /// [`Filter::effective_pixels`](crate::Filter::effective_pixels).
    #[must_use]
    pub fn for_effective_samples(samples: f64) -> Self {
        Self((0.25 / samples.max(1.0).sqrt()) as f32)
    }

    /// ε itself.
    #[must_use]
    pub const fn epsilon(self) -> f32 {
        self.0
    }

    /// The error that chords of curved stretches may cost: a quarter of ε, at least
    /// [`Self::CHORD_FLOOR`].
    #[must_use]
    pub fn chord(self) -> f64 {
        (0.25 * f64::from(self.0)).max(Self::CHORD_FLOOR)
    }

    /// The remainder of ε once `spent` is gone. A later stage may use the error
    /// that an earlier one does not.
    #[must_use]
    pub fn after(self, spent: f64) -> Self {
        let left = (f64::from(self.0) - spent).max(0.0);
        // Rounding up would hand out more than there is.
        let rounded = left as f32;
        Self(if f64::from(rounded) > left { rounded.next_down() } else { rounded })
    }
}

impl TryFrom<f32> for Tolerance {
    type Error = Error;

    fn try_from(epsilon: f32) -> Result<Self> {
        Self::new(epsilon)
    }
}

impl From<Tolerance> for f32 {
    fn from(tolerance: Tolerance) -> Self {
        tolerance.epsilon()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuses_what_is_no_bound() {
        for epsilon in [-0.1, 1.0, f32::NAN, f32::INFINITY] {
            assert!(Tolerance::new(epsilon).is_err(), "{epsilon}");
        }
    }

    #[test]
    fn sixteen_samples_allow_a_sixteenth() {
        assert_eq!(Tolerance::for_samples(16).epsilon(), 0.0625);
    }

    #[test]
    fn stages_never_spend_more_than_there_is() {
        let tolerance = Tolerance::new(0.02).unwrap();
        let rest = tolerance.after(tolerance.chord());
        assert!(f64::from(rest.epsilon()) + tolerance.chord() <= f64::from(tolerance.epsilon()));
        assert_eq!(Tolerance::EXACT.chord(), Tolerance::CHORD_FLOOR);
        assert_eq!(Tolerance::EXACT.after(Tolerance::CHORD_FLOOR), Tolerance::EXACT);
    }
}
