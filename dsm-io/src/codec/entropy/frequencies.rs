//! How frequent the tokens of one kind are.

use super::bits::{BitReader, BitWriter};
use super::token::TOKENS;

/// The frequencies of all tokens have this sum, a power of two.
pub(super) const TOTAL: u32 = 1 << TOTAL_BITS;

pub(super) const TOTAL_BITS: u32 = 10;

/// The largest place of a count on the scale: that of 2³².
const MOST_SCALE: u32 = 129;

/// The frequencies of tokens: 0 of those that do not occur, and [`TOTAL`] in all, or 0
/// where no token does.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Frequencies(pub(super) [u32; TOKENS]);

/// Counts on a scale with four steps an octave: 0, then 4, 5, 6, 7, 8, 10, 12, 14, 16 …
/// fourths.
const fn on_scale(scale: u32) -> u64 {
    match scale.checked_sub(1) {
        None => 0,
        Some(step) => (4 + (step % 4) as u64) << (step / 4),
    }
}

/// The place of the count nearest to `count` on the scale.
fn scale_of(count: u32) -> u32 {
    if count == 0 {
        return 0;
    }
    let fourths = u64::from(count) * 4;
    let octave = count.ilog2();
    // Half a step up, then down.
    let steps = (2 * fourths + (1 << octave)) >> (octave + 1);
    1 + 4 * octave + (steps as u32 - 4)
}

/// Where signed changes stand among numbers.
const fn zigzag(change: i32) -> u32 {
    ((change << 1) ^ (change >> 31)).cast_unsigned()
}

impl Frequencies {
    /// Writes what tells how frequent tokens are that occur so often; those frequencies.
    pub(super) fn write(counts: &[u32; TOKENS], bits: &mut BitWriter) -> Self {
        let used = TOKENS - counts.iter().rev().take_while(|&&count| count == 0).count();
        bits.push_gamma(used as u32);
        let scales = counts.map(scale_of);
        let mut before = 0;
        for &scale in &scales[..used] {
            bits.push_gamma(zigzag(scale.cast_signed() - before));
            before = scale.cast_signed();
        }
        Self::of_scales(&scales)
    }

    /// Reads what [`Self::write`] wrote; none if it makes no sense.
    pub(super) fn read(bits: &mut BitReader<'_>) -> Option<Self> {
        let used = bits.take_gamma()? as usize;
        let mut scales = [0; TOKENS];
        let mut before = 0_u32;
        for scale in scales.get_mut(..used)? {
            let change = bits.take_gamma()?;
            before = before.wrapping_add((change >> 1) ^ (change & 1).wrapping_neg());
            if before > MOST_SCALE {
                return None;
            }
            *scale = before;
        }
        Some(Self::of_scales(&scales))
    }

    /// In proportion to counts on the scale, but at least 1; the most frequent token has
    /// what that leaves.
    fn of_scales(scales: &[u32; TOKENS]) -> Self {
        let weights = scales.map(on_scale);
        let sum: u64 = weights.iter().sum();
        let mut frequencies = [0; TOKENS];
        if sum == 0 {
            return Self(frequencies);
        }
        let mut most = 0;
        for (token, &weight) in weights.iter().enumerate() {
            if weight > 0 {
                frequencies[token] = ((weight * u64::from(TOTAL) / sum) as u32).max(1);
            }
            if weight > weights[most] {
                most = token;
            }
        }
        // Above 0: where r of 64 tokens were raised to 1, the most frequent has a share
        // above 1024 / (64 − r), which is r at least.
        let others: u32 = frequencies.iter().sum::<u32>() - frequencies[most];
        frequencies[most] = TOTAL - others;
        Self(frequencies)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_is_near_every_count() {
        for count in (0..3000).chain([1 << 20, 3 << 29, u32::MAX]) {
            let scale = scale_of(count);
            let fourths = u64::from(count) * 4;
            assert!(on_scale(scale).abs_diff(fourths) * 8 <= fourths, "{count}");
            assert!(scale <= MOST_SCALE);
        }
    }

    #[test]
    fn frequencies_come_back_and_leave_room_for_every_token() {
        for seed in 1..500_u32 {
            let noise =
                |token: usize| (token as u32 + 7).wrapping_mul(seed).wrapping_mul(0x9e37_79b9);
            // Half of the tokens rare, or all of one kind, or some.
            let counts: [u32; TOKENS] = std::array::from_fn(|token| match seed % 3 {
                0 => (token as u32 % 2 * seed * seed).max(1),
                1 => u32::from(token as u32 == seed % 64) * seed,
                _ => noise(token) >> (noise(token) % 40).min(31),
            });
            let mut writer = BitWriter::default();
            let written = Frequencies::write(&counts, &mut writer);
            assert_eq!(written.0.iter().sum::<u32>(), TOTAL);
            for (frequency, count) in written.0.iter().zip(counts) {
                assert_eq!(*frequency > 0, count > 0);
            }
            let bytes = writer.finish();
            assert_eq!(Frequencies::read(&mut BitReader::new(&bytes)), Some(written));
        }
        assert_eq!(Frequencies::read(&mut BitReader::new(&[])), None);
    }
}
