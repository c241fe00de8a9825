//! Bytes into numbers.

use super::bits::BitReader;
use super::encoder::LEAST_STATE;
use super::frequencies::{Frequencies, TOTAL, TOTAL_BITS};
use super::token::{LEAST, open_width};

/// What a share of the numeral system stands for: a token, its frequency and how far
/// within its shares this one is, in one word. 0 where there is no token.
#[derive(Clone, Copy, Debug, Default)]
struct Share(u32);

impl Share {
    const fn new(token: usize, frequency: u32, within: u32) -> Self {
        Self(token as u32 | within << 6 | frequency << 16)
    }

    const fn token(self) -> u32 {
        self.0 & 63
    }

    const fn within(self) -> u32 {
        self.0 >> 6 & 1023
    }

    const fn frequency(self) -> u32 {
        self.0 >> 16
    }
}

/// Gives the numbers that an encoder took, in the same order.
///
/// Of bytes that no encoder made it gives numbers that mean nothing, as many as are
/// asked for: whoever asks bounds how many, and [`Self::is_finished`] tells in the end.
#[derive(Clone, Debug)]
pub(in crate::codec) struct Decoder<'a> {
    /// Of each kind [`TOTAL`].
    shares: Vec<Share>,
    bits: BitReader<'a>,
    /// What is left of the words, the next one last.
    words: &'a [u8],
    next: u32,
    after: u32,
}

impl<'a> Decoder<'a> {
    /// Reads the frequencies of all kinds; none if there are none.
    pub(in crate::codec) fn new(bytes: &'a [u8], kinds: usize) -> Option<Self> {
        let mut bits = BitReader::new(bytes);
        let mut shares = vec![Share::default(); kinds << TOTAL_BITS];
        for mut rest in shares.chunks_exact_mut(TOTAL as usize) {
            for (token, frequency) in Frequencies::read(&mut bits)?.0.into_iter().enumerate() {
                let (own, others) = rest.split_at_mut(frequency as usize);
                rest = others;
                for (within, share) in (0..).zip(own) {
                    *share = Share::new(token, frequency, within);
                }
            }
        }
        let (words, after) = bytes.split_last_chunk()?;
        let (words, next) = words.split_last_chunk()?;
        let [next, after] = [*next, *after].map(u32::from_le_bytes);
        Some(Self { shares, bits, words, next, after })
    }

    /// The next number, of this kind.
    ///
    /// Whether a word or open bits are needed cannot be foreseen: neither is branched on.
    #[inline(always)]
    pub(in crate::codec) fn take(&mut self, kind: usize) -> u32 {
        let share = self.shares[kind << TOTAL_BITS | (self.next % TOTAL) as usize];
        let state = share.frequency() * (self.next >> TOTAL_BITS) + share.within();
        let (words, word) = match self.words.split_last_chunk() {
            Some((words, word)) => (words, u16::from_le_bytes(*word)),
            None => (self.words, 0),
        };
        let is_low = state < LEAST_STATE;
        self.next = self.after;
        self.after = if is_low { state << 16 | u32::from(word) } else { state };
        let length = if is_low { words.len() } else { self.words.len() };
        self.words = self.words.get(..length).unwrap_or(words);
        let token = share.token();
        LEAST[token as usize] + self.bits.take(open_width(token))
    }

    /// True if all numbers were taken, and the bytes hold nothing else.
    pub(in crate::codec) fn is_finished(&mut self) -> bool {
        let ended = [self.next, self.after] == [LEAST_STATE; 2];
        ended && self.bits.end() == Some(self.words.len())
    }
}

#[cfg(test)]
mod tests {
    use super::super::Encoder;
    use super::*;

    fn numbers(count: u32) -> Vec<(usize, u32)> {
        let noise = |index: u32| index.wrapping_mul(0x9e37_79b9) ^ index >> 3;
        (0..count)
            .map(|index| match index % 4 {
                0 | 1 => (0, noise(index) >> 28),
                2 => (2, noise(index) >> (noise(index) % 29)),
                _ => (3, 7),
            })
            .collect()
    }

    fn encode(numbers: &[(usize, u32)]) -> Vec<u8> {
        let mut encoder = Encoder::new(5);
        numbers.iter().for_each(|&(kind, number)| encoder.push(kind, number));
        encoder.finish()
    }

    #[test]
    fn numbers_come_back_and_nothing_else_is_taken() {
        for count in [0, 1, 2, 3, 1000, 60_000] {
            let numbers = numbers(count);
            let bytes = encode(&numbers);
            let read = |bytes: &[u8]| {
                let mut decoder = Decoder::new(bytes, 5)?;
                let same = numbers.iter().all(|&(kind, number)| decoder.take(kind) == number);
                Some(decoder.is_finished() && same)
            };
            assert_eq!(read(&bytes), Some(true), "{count}");
            // A byte more or less, or another one, is seen.
            for at in (0..bytes.len()).step_by(1 + bytes.len() / 200) {
                let mut changed = bytes.clone();
                changed[at] ^= 1 << (at % 8);
                assert_ne!(read(&changed), Some(true), "{count} {at}");
                changed.truncate(at);
                assert_ne!(read(&changed), Some(true), "{count} {at}");
            }
            assert_ne!(read(&[&bytes, &[0][..]].concat()), Some(true));
            assert_ne!(read(&[&[0][..], &bytes].concat()), Some(true));
        }
    }

    #[test]
    fn frequent_numbers_cost_little() {
        // 15 of 16 are alike: a third of a bit each.
        let numbers: Vec<(usize, u32)> =
            (0..16_000).map(|index| (1, if index % 16 == 0 { 3 } else { 1 })).collect();
        let bits = 8 * encode(&numbers).len();
        assert!((5300..5800).contains(&bits), "{bits}");
    }
}
