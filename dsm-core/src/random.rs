//! Numbers that look random and are the same every time.

/// The odd number nearest to 2⁶⁴ over the golden ratio.
pub(crate) const WEYL: u64 = 0x9E37_79B9_7F4A_7C15;

/// A bijection of 64 bits after which every bit depends on every other: the
/// output function of SplitMix64 (Steele, Lea & Flood 2014).
pub(crate) fn mix(value: u64) -> u64 {
    let value = value.wrapping_add(WEYL);
    let value = (value ^ (value >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let value = (value ^ (value >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    value ^ (value >> 31)
}

/// The next number of SplitMix64 (Steele, Lea & Flood 2014), and the state
/// after it: every first state gives a sequence of its own, of 2⁶⁴ numbers.
#[must_use]
pub fn next_bits(state: &mut u64) -> u64 {
    let bits = mix(*state);
    *state = state.wrapping_add(WEYL);
    bits
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
}
