//! Sorts of events by depth.

/// Up to as many keys are sorted by counting, for each, those before it.
const RANK_UP_TO: usize = 24;

/// The number of keys from which on a radix sort is faster than comparisons.
const RADIX_FROM: usize = 256;

const DIGIT_BITS: u32 = 8;

const BUCKETS: usize = 1 << DIGIT_BITS;

/// Sorts distinct keys that hold the bits of a finite, non-negative depth above
/// 32 bits of anything. `spare` is scratch memory.
///
/// Hits come in no order, which comparison sorts pay for with mispredicted
/// branches. So both the few hits of a ray and the many of a pixel are sorted
/// without branches.
pub(super) fn sort_by_depth(keys: &mut Vec<u64>, spare: &mut Vec<u64>) {
    match keys.len() {
        0..=RANK_UP_TO => sort_by_rank(keys, spare),
        RADIX_FROM.. => sort_by_digits(keys, spare),
        _ => keys.sort_unstable(),
    }
}

/// Puts every key behind as many as are smaller: O(n²) without a branch.
fn sort_by_rank(keys: &mut Vec<u64>, spare: &mut Vec<u64>) {
    spare.resize(keys.len(), 0);
    for &key in keys.iter() {
        // Bits of a finite f32 on top make a finite f64 of the same order,
        // which plain x86-64 compares two at a time.
        let key_as_float = f64::from_bits(key);
        let before = |&other: &u64| usize::from(f64::from_bits(other) < key_as_float);
        let rank: usize = keys.iter().map(before).sum();
        spare[rank] = key;
    }
    std::mem::swap(keys, spare);
}

/// A radix sort that looks only at the bits in which the depths differ: O(n).
/// Keys of one depth keep their order.
fn sort_by_digits(keys: &mut Vec<u64>, spare: &mut Vec<u64>) {
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
        for count in [0_usize, 1, 24, 25, 255, 256, 500, 3000] {
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
                sort_by_depth(&mut keys, &mut vec![7; 100]);
                assert_eq!(keys, expected);
            }
        }
    }

    #[test]
    fn the_ends_of_the_range_are_in_order() {
        let depths = [f32::MAX, 0.0, 1.0, f32::from_bits(1)];
        for count in [8, 400] {
            let keys = depths.iter().cycle().zip(0..count);
            let mut keys: Vec<u64> =
                keys.map(|(z, index)| u64::from(z.to_bits()) << 32 | index).collect();
            sort_by_depth(&mut keys, &mut Vec::new());
            assert!(keys.is_sorted_by(|a, b| a < b));
            assert_eq!(keys.len() as u64, count);
        }
    }
}
