//! Sums and products that carry what `f64` rounding drops.
//!
//! No fused multiply-add: without that instruction, which plain x86-64
//! lacks, it is a library call.

use crate::transmittance::Transmittance;

/// a + b and its rounding error, exactly (Knuth's two-sum).
pub(crate) fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_part = sum - a;
    (sum, (a - (sum - b_part)) + (b - b_part))
}

/// a + b and its rounding error, exactly, for |a| ≥ |b| or a = 0 (Dekker's fast
/// two-sum).
pub(crate) fn fast_two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    (sum, b - (sum - a))
}

/// a · b and its rounding error, exactly (Dekker's product), for factors
/// below 1e290 and products above 1e-290.
pub(crate) fn two_product(a: f64, b: f64) -> (f64, f64) {
    let (a_high, a_low) = split(a);
    let (b_high, b_low) = split(b);
    let product = a * b;
    let error = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low;
    (product, error)
}

/// A number as two with 26 significant bits each (Veltkamp).
fn split(a: f64) -> (f64, f64) {
    const FACTOR: f64 = 134_217_729.0; // 2²⁷ + 1
    let scaled = FACTOR * a;
    let high = scaled - (scaled - a);
    (high, a - high)
}

/// A running sum with its rounding error, one a channel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RunningSum<T: Transmittance> {
    sum: T::Sum,
    error: T::Sum,
}

impl<T: Transmittance> RunningSum<T> {
    /// Starts at `value` in every channel.
    pub(crate) fn new(value: f64) -> Self {
        Self { sum: T::sum_from_channels(|_| value), error: T::sum_from_channels(|_| 0.0) }
    }

    /// Adds `term` to `channel`.
    #[inline]
    pub(crate) fn add(&mut self, channel: usize, term: f64) {
        let (sum, error) = two_sum(self.sum.as_ref()[channel], term);
        self.sum.as_mut()[channel] = sum;
        self.error.as_mut()[channel] += error;
    }

    /// The sum of `channel`.
    #[inline]
    pub(crate) fn channel(&self, channel: usize) -> f64 {
        self.sum.as_ref()[channel] + self.error.as_ref()[channel]
    }

    /// The sums of all channels.
    #[inline]
    pub(crate) fn value(&self) -> T::Sum {
        T::sum_from_channels(|channel| self.channel(channel))
    }
}

/// The transmittance of surfaces: a running product of 1 − opacity, one a channel,
/// with its rounding error. The two are not brought back in line after each factor:
/// that would double the time a factor has to wait for the last.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RunningTransmittance<T: Transmittance> {
    product: T::Sum,
    error: T::Sum,
}

impl<T: Transmittance> RunningTransmittance<T> {
    /// Nothing in the way.
    pub(crate) fn clear() -> Self {
        Self { product: T::sum_from_channels(|_| 1.0), error: T::sum_from_channels(|_| 0.0) }
    }

    /// Puts a surface in the way.
    #[inline]
    pub(crate) fn block(&mut self, opacity: T) {
        // The upper 26 bits: times an f32, both parts are exact.
        const UPPER: u64 = !0x7FF_FFFF;
        for channel in 0..T::CHANNELS {
            let opacity = f64::from(opacity.channel(channel));
            let (product, error) =
                (&mut self.product.as_mut()[channel], &mut self.error.as_mut()[channel]);
            if opacity == 1.0 {
                (*product, *error) = (0.0, 0.0);
            } else {
                let high = f64::from_bits(product.to_bits() & UPPER);
                let low = *product - high;
                let (difference, rounding) = fast_two_sum(*product, -high * opacity);
                *error += (rounding - low * opacity) - *error * opacity;
                *product = difference;
            }
        }
    }

    /// The product of `channel`.
    #[inline]
    pub(crate) fn channel(&self, channel: usize) -> f64 {
        (self.product.as_ref()[channel] + self.error.as_ref()[channel]).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_keep_their_error() {
        let (a, b) = (1.0 + f64::EPSILON, 1.0 - f64::EPSILON);
        assert_eq!(two_product(a, b), (1.0, -f64::EPSILON * f64::EPSILON));
    }

    #[test]
    fn sums_keep_what_rounding_drops() {
        let mut sum = RunningSum::<f32>::new(1.0);
        for _ in 0..1000 {
            sum.add(0, 1e-17);
        }
        sum.add(0, -1.0);
        assert!((sum.channel(0) - 1e-14).abs() < 1e-26, "{}", sum.channel(0));
    }

    #[test]
    fn a_million_faint_surfaces_multiply_exactly() {
        let mut transmittance = RunningTransmittance::<f32>::clear();
        let opacity = 2.0_f32.powi(-24);
        for _ in 0..1_000_000 {
            transmittance.block(opacity);
        }
        let exact = (1e6 * f64::ln_1p(-f64::from(opacity))).exp();
        assert!((transmittance.channel(0) - exact).abs() < 2e-16);
        transmittance.block(1.0);
        assert_eq!(transmittance.channel(0), 0.0);
    }
}
