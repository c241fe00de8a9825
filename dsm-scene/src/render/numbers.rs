//! Numbers that look random and are the same whoever asks.

use dsm_core::next_bits;

/// Numbers of one sample of one pixel: SplitMix64, whose state is hashed from
/// what it is for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Numbers(u64);

impl Numbers {
    pub(super) fn of(seed: u64, [x, y]: [u32; 2]) -> Self {
        let pixel = u64::from(x) | u64::from(y) << 32;
        let mut numbers = Self(seed);
        let bits = numbers.bits();
        Self(bits ^ pixel.wrapping_mul(0xd6e8_feb8_6659_fd93))
    }

    pub(super) fn bits(&mut self) -> u64 {
        next_bits(&mut self.0)
    }

    /// A number in [0, 1).
    pub(super) fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / 2.0_f64.powi(53)
    }
}

/// One of `count` numbers that fill [0, 1) evenly: golden steps from `start`.
pub(super) fn spread(start: f64, index: u32) -> f64 {
    (start + f64::from(index) * 0.618_033_988_749_895).fract()
}

/// The same in steps that have nothing to do with those of [`spread`].
pub(super) fn spread_otherwise(start: f64, index: u32) -> f64 {
    (start + f64::from(index) * std::f64::consts::SQRT_2).fract()
}
