//! Sorts what happens along z.

/// Fewer keys than this are sorted by comparison.
const RADIX_FROM: usize = 256;

const DIGIT_BITS: u32 = 8;

const BUCKETS: usize = 1 << DIGIT_BITS;

/// Sorts keys that hold the bits of a non-negative depth above 32 bits of
/// anything by depth, keys of one depth in any order. `spare` is scratch
/// memory.
///
/// A radix sort that looks only at the bits in which the depths differ: linear,
/// and free of branches that a comparison sort would mispredict.
pub(super) fn sort_by_depth(keys: &mut Vec<u64>, spare: &mut Vec<u64>) {
    if keys.len() < RADIX_FROM {
        keys.sort_unstable();
        return;
    }
    let (mut low, mut high) = (u64::MAX, 0);
    for &key in keys.iter() {
        (low, high) = (low.min(key), high.max(key));
    }
    let low = (low >> 32) << 32;
    let bits = 64 - ((high - low) >> 32).leading_zeros();
    spare.resize(keys.len(), 0);
    for pass in 0..bits.div_ceil(DIGIT_BITS) {
        let shift = 32 + pass * DIGIT_BITS;
        let digit = |key: u64| ((key - low) >> shift) as usize % BUCKETS;
        let mut places = [0_u32; BUCKETS];
        for &key in keys.iter() {
            places[digit(key)] += 1;
        }
        let mut start = 0;
        for place in &mut places {
            start += std::mem::replace(place, start);
        }
        for &key in keys.iter() {
            let place = &mut places[digit(key)];
            spare[*place as usize] = key;
            *place += 1;
        }
        std::mem::swap(keys, spare);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sorts_depths_of_any_magnitude() {
        for count in [0_usize, 1, 255, 256, 500, 3000] {
            for magnitudes in [1_u32, 60] {
                let mut state = count as u64;
                let mut keys: Vec<u64> = (0..count)
                    .map(|index| {
                        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                        let exponent = (state >> 33) as u32 % magnitudes;
                        let z = (3.0 + (state >> 50) as f32) * 2.0_f32.powi(exponent as i32);
                        u64::from(z.to_bits()) << 32 | index as u64
                    })
                    .collect();
                let mut expected = keys.clone();
                expected.sort_unstable();
                sort_by_depth(&mut keys, &mut Vec::new());
                // Stable, so that the indices ascend, too.
                assert_eq!(keys, expected);
            }
        }
    }

    #[test]
    fn the_ends_of_the_range_are_in_order() {
        let depths = [f32::MAX, 0.0, 1.0, f32::from_bits(1)];
        let mut keys: Vec<u64> =
            depths.iter().cycle().take(400).map(|z| u64::from(z.to_bits()) << 32).collect();
        sort_by_depth(&mut keys, &mut Vec::new());
        assert!(keys.is_sorted());
        assert_eq!(keys[99..101], [0, 1 << 32]);
    }
}
