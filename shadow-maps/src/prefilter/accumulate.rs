//! How the opacities of several fragments become one.

use dsm_core::Transmittance;
use serde::{Deserialize, Serialize};

/// The accumulation of the opacities of fragments that light passes one after the
/// other (Selgrad et al. 2014, §6).
///
/// ```
/// use shadow_maps::detail::Accumulate;
///
/// let halves = |mode: Accumulate| mode.of::<f32>([0.5, 0.5]);
/// assert_eq!(halves(Accumulate::Add), 1.0);
/// assert_eq!(halves(Accumulate::Multiply), 0.75);
/// assert_eq!(halves(Accumulate::Max), 0.5);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Accumulate {
    /// Their sum: none lies behind another.
    Add,
    /// What is left is the product of what each leaves: they lie independently.
    #[default]
    Multiply,
    /// The largest: the others lie behind it.
    Max,
}

impl Accumulate {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Add, Self::Multiply, Self::Max];

    /// The name on the command line and in headers.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Add => "add",
            Self::Multiply => "multiply",
            Self::Max => "max",
        }
    }

    /// The mode of this name, if there is one.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|mode| mode.name() == name)
    }

    /// One more opacity of one channel. Sums are not held to 1.
    #[must_use]
    #[inline]
    pub fn with(self, so_far: f64, opacity: f64) -> f64 {
        match self {
            Self::Add => so_far + opacity,
            Self::Multiply => so_far + opacity * (1.0 - so_far),
            Self::Max => so_far.max(opacity),
        }
    }

    /// The opacity of all of these, in [0, 1].
    #[must_use]
    pub fn of<T: Transmittance>(self, opacities: impl IntoIterator<Item = T>) -> T {
        let mut all = T::BLOCKED.to_sum();
        for opacity in opacities {
            for (so_far, one) in all.as_mut().iter_mut().zip(opacity.to_sum().as_ref()) {
                *so_far = self.with(*so_far, *one);
            }
        }
        all.as_mut().iter_mut().for_each(|sum| *sum = sum.min(1.0));
        T::from_sum(all)
    }
}
