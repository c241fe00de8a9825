//! A running sum that gives back what is taken out of it.

use super::compensated::{fast_two_sum, two_sum};

/// Exponents that share a bin: with 53 bits of mantissa this leaves room for
/// 2²¹ terms before a pair of `f64` has to round.
const BIN_EXPONENTS: u64 = 32;

/// A running sum of terms of any magnitude, free of rounding: subtracting
/// what was added leaves exactly what was there before.
///
/// A ramp between neighbouring floats has a slope of 1e45, and 1e45 − 1e45
/// must not leave a residue that the next, long stretch multiplies. So terms
/// are sorted into bins by their exponent, and each bin is a pair of `f64`
/// wide enough for the exact sum of up to 2²¹ terms. O(1) a term.
#[derive(Clone, Debug)]
pub(crate) struct ExactSum {
    /// Bit i: bin i is not 0.
    used: u64,
    bins: [(f64, f64); 64],
}

impl Default for ExactSum {
    fn default() -> Self {
        Self { used: 0, bins: [(0.0, 0.0); 64] }
    }
}

impl ExactSum {
    /// Back to no terms.
    pub(crate) fn clear(&mut self) {
        while self.used != 0 {
            self.bins[self.used.trailing_zeros() as usize] = (0.0, 0.0);
            self.used &= self.used - 1;
        }
    }

    /// True if the sum is 0.
    pub(crate) const fn is_empty(&self) -> bool {
        self.used == 0
    }

    /// Adds `term`, which must be finite and below 1e290.
    #[inline]
    pub(crate) fn add(&mut self, term: f64) {
        let exponent = (term.to_bits() >> 52) & 0x7FF;
        let index = (exponent / BIN_EXPONENTS) as usize;
        let (high, low) = self.bins[index];
        let (sum, error) = two_sum(high, term);
        self.bins[index] = fast_two_sum(sum, low + error);
        let bit = 1 << index;
        self.used = if self.bins[index].0 == 0.0 { self.used & !bit } else { self.used | bit };
    }

    /// The sum and what rounding it to `f64` drops.
    #[inline]
    pub(crate) fn value(&self) -> (f64, f64) {
        let (mut sum, mut error) = (0.0, 0.0);
        let mut left = self.used;
        while left != 0 {
            let (high, low) = self.bins[left.trailing_zeros() as usize];
            let rounding;
            (sum, rounding) = two_sum(sum, high);
            error += rounding + low;
            left &= left - 1;
        }
        fast_two_sum(sum, error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_goes_out_leaves_no_residue() {
        let terms = [3.0e44, 1e-3, -7.7e20, 0.1, 1e16, 5e-324, -2.5e-17, 1e100];
        let mut sum = ExactSum::default();
        for _ in 0..1000 {
            terms.iter().for_each(|&term| sum.add(term));
        }
        for &term in terms.iter().filter(|&&term| term != 0.1) {
            (0..1000).for_each(|_| sum.add(-term));
        }
        assert_eq!(sum.value().0, 0.1 * 1000.0);
        (0..1000).for_each(|_| sum.add(-0.1));
        assert!(sum.is_empty());
        assert_eq!(sum.value(), (0.0, 0.0));
    }

    #[test]
    fn clearing_forgets() {
        let mut sum = ExactSum::default();
        sum.add(1.0);
        sum.add(1e80);
        sum.clear();
        sum.add(2.0);
        assert_eq!(sum.value(), (2.0, 0.0));
    }
}
