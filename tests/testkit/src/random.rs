//! Numbers that look random and are the same in every run.

use dsm_core::detail::random::next_bits;

/// A stream of numbers: every seed has its own.
///
/// ```
/// use dsm_testkit::Random;
///
/// let (mut first, mut again) = (Random::new(7), Random::new(7));
/// assert_eq!(first.below(1000), again.below(1000));
/// assert!((0.0..1.0).contains(&first.unit()));
/// ```
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// The stream of `seed`.
    #[must_use]
    pub const fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// 64 bits.
    pub fn bits(&mut self) -> u64 {
        next_bits(&mut self.0)
    }

    /// A number in [0, 1), a multiple of 2⁻²⁴: an `f32`, too.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 40) as f64 / f64::from(1 << 24)
    }

    /// A number below `end`, which is at least 1.
    pub fn below(&mut self, end: u64) -> u64 {
        self.bits() % end
    }
}
