//! Random numbers that are functions of what they are for.

/// Constants of a well mixing multiply and xorshift hash of 32 bits (found by
/// C. Wellons' search, "lowbias32").
pub(crate) const FACTORS: [u32; 2] = [0x7feb_352d, 0x846c_a68b];

/// A bijection of 32 bits after which every bit depends on every other.
pub(crate) const fn mix(value: u32) -> u32 {
    let value = (value ^ (value >> 16)).wrapping_mul(FACTORS[0]);
    let value = (value ^ (value >> 15)).wrapping_mul(FACTORS[1]);
    value ^ (value >> 16)
}

/// The upper 24 bits as a number in (0, 1).
pub(crate) fn unit(bits: u32) -> f64 {
    (f64::from(bits >> 8) + 0.5) / f64::from(1 << 24)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_are_independent() {
        let count = 1 << 16;
        let (mut sum, mut product) = (0.0, 0.0);
        for index in 0..count {
            let [here, next] = [index, index + 1].map(|index| unit(mix(index)) - 0.5);
            sum += here;
            product += here * next;
        }
        // Four standard deviations.
        let root = f64::from(count).sqrt();
        assert!(sum.abs() < 4.0 * root / 12.0_f64.sqrt(), "{sum}");
        assert!(product.abs() < 4.0 * root / 12.0, "{product}");
    }
}
