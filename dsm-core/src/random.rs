//! Pseudo-random numbers, reproducible on every platform.
//!
//! The crates that bake, trace and render take theirs from here: 64 bits by
//! SplitMix64 ([`next_bits`], [`mix`]), 32 bits where many are made at once in
//! vectors ([`mix32`]), and the hash of a list of numbers ([`combine`]).

/// The odd number nearest to 2⁶⁴ over the golden ratio.
pub(crate) const WEYL: u64 = 0x9E37_79B9_7F4A_7C15;

/// The golden ratio less 1, rounded to 15 digits: multiples of it, less their
/// whole parts, fill [0, 1) evenly, whatever their number.
const GOLDEN_STEP: f64 = 0.618_033_988_749_895;

/// A bijection of 64 bits after which every bit depends on every other: the
/// output function of SplitMix64 (Steele, Lea & Flood 2014).
#[inline]
#[must_use]
pub fn mix(value: u64) -> u64 {
    let value = value.wrapping_add(WEYL);
    let value = (value ^ (value >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let value = (value ^ (value >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    value ^ (value >> 31)
}

/// The next number of SplitMix64 (Steele, Lea & Flood 2014), and the state
/// after it: every first state gives a sequence of its own, of 2⁶⁴ numbers.
///
/// ```
/// use dsm_core::detail::random::{next_bits, unit};
///
/// let mut state = 7;
/// let numbers = [unit(next_bits(&mut state)), unit(next_bits(&mut state))];
/// assert!(numbers[0] != numbers[1] && numbers.iter().all(|n| (0.0..1.0).contains(n)));
/// ```
#[inline]
#[must_use]
pub fn next_bits(state: &mut u64) -> u64 {
    let bits = mix(*state);
    *state = state.wrapping_add(WEYL);
    bits
}

/// A seed that is far from those of neighbouring numbers, so that what counts
/// up from one does not run into the next.
#[inline]
#[must_use]
pub const fn scattered_seed(seed: u64) -> u64 {
    seed.wrapping_mul(WEYL)
}

/// The factor of [`combine`].
pub const COMBINING_FACTOR: u64 = 0xD6E8_FEB8_6659_FD93;

/// The hash of a list's beginning, made that of one number more: a
/// multiplication and an xorshift, faster than [`mix`] and too little for numbers
/// that count up.
#[inline]
#[must_use]
pub const fn combine(hash: u64, number: u64) -> u64 {
    let bits = (hash ^ number).wrapping_mul(COMBINING_FACTOR);
    bits ^ (bits >> 32)
}

/// The hash of an empty list, for [`combine`].
pub const EMPTY_HASH: u64 = WEYL;

/// The upper 53 bits as a number in [0, 1).
#[inline]
#[must_use]
pub fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 / 2.0_f64.powi(53)
}

/// Number `index` of a sequence that fills [0, 1) evenly: steps by the golden
/// ratio, from `start` in [0, 1).
///
/// ```
/// use dsm_core::detail::random::golden;
///
/// let mut numbers: Vec<f64> = (0..8).map(|index| golden(0.0, f64::from(index))).collect();
/// numbers.sort_by(f64::total_cmp);
/// assert!(numbers.windows(2).all(|pair| (0.05..0.2).contains(&(pair[1] - pair[0]))));
/// ```
#[inline]
#[must_use]
pub fn golden(start: f64, index: f64) -> f64 {
    (start + index * GOLDEN_STEP).fract()
}

/// The factors of [`mix32`], for those who do the same to a vector of numbers.
pub const MIX32_FACTORS: [u32; 2] = [0x7FEB_352D, 0x846C_A68B];

/// A bijection of 32 bits after which every bit depends on every other, by
/// multiplications that vectors of 32-bit lanes have: C. Wellons' "lowbias32".
#[inline]
#[must_use]
pub const fn mix32(value: u32) -> u32 {
    let value = (value ^ (value >> 16)).wrapping_mul(MIX32_FACTORS[0]);
    let value = (value ^ (value >> 15)).wrapping_mul(MIX32_FACTORS[1]);
    value ^ (value >> 16)
}

/// The upper 24 bits as a number in (0, 1).
#[inline]
#[must_use]
pub fn unit32(bits: u32) -> f64 {
    (f64::from(bits >> 8) + 0.5) / f64::from(1 << 24)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sequence_is_that_of_splitmix64() {
        // The generator's published first numbers for seed 1234567.
        let mut state = 1_234_567;
        let first = [6_457_827_717_110_365_317, 3_203_168_211_198_807_973];
        assert_eq!([next_bits(&mut state), next_bits(&mut state)], first);
    }

    #[test]
    fn the_ends_of_the_units_are_open_where_they_say_so() {
        assert_eq!((unit(0), unit(u64::MAX)), (0.0, 1.0_f64.next_down()));
        assert!(unit32(0) > 0.0 && unit32(u32::MAX) < 1.0);
    }

    #[test]
    fn lists_that_differ_have_other_hashes() {
        let lists = [[0, 0], [0, 1], [1, 0], [1, 1]];
        let mut hashes = lists.map(|list| list.into_iter().fold(EMPTY_HASH, combine));
        hashes.sort_unstable();
        assert!(hashes.windows(2).all(|pair| pair[0] != pair[1]), "{hashes:?}");
    }

    #[test]
    fn neighbours_are_independent() {
        let count = 1 << 16;
        let numbers: [fn(u32) -> f64; 2] =
            [|index| unit32(mix32(index)), |index| unit(mix(index.into()))];
        for number in numbers {
            let (mut sum, mut product) = (0.0, 0.0);
            for index in 0..count {
                let [here, next] = [index, index + 1].map(|index| number(index) - 0.5);
                sum += here;
                product += here * next;
            }
            // Four standard deviations.
            let root = f64::from(count).sqrt();
            assert!(sum.abs() < 4.0 * root / 12.0_f64.sqrt(), "{sum}");
            assert!(product.abs() < 4.0 * root / 12.0, "{product}");
        }
    }
}
