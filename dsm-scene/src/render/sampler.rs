//! Reproducible random numbers of a camera sample.

use dsm_core::detail::random::COMBINING_FACTOR;
use dsm_core::detail::random::{next_bits, unit};

/// The random numbers of one sample of one pixel: SplitMix64, whose state is
/// hashed from the seed and the pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sampler(u64);

impl Sampler {
    pub(super) fn of(seed: u64, [x, y]: [u32; 2]) -> Self {
        let pixel = u64::from(x) | u64::from(y) << 32;
        let mut sampler = Self(seed);
        let bits = sampler.bits();
        Self(bits ^ pixel.wrapping_mul(COMBINING_FACTOR))
    }

    pub(super) fn bits(&mut self) -> u64 {
        next_bits(&mut self.0)
    }

    /// A number in [0, 1).
    pub(super) fn unit(&mut self) -> f64 {
        unit(self.bits())
    }
}

/// One of the numbers that fill [0, 1) evenly, in steps that have nothing to do
/// with those of the golden ratio.
pub(super) fn spread_otherwise(start: f64, index: u32) -> f64 {
    (start + f64::from(index) * std::f64::consts::SQRT_2).fract()
}
