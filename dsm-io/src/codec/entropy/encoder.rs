//! Numbers into bytes.

use super::bits::BitWriter;
use super::frequencies::{Frequencies, TOTAL_BITS};
use super::token::{TOKENS, Token};

/// The state of the numeral system is at least this between two tokens.
pub(super) const LEAST_STATE: u32 = 1 << 16;

/// Takes numbers of some kinds, and writes them once all are there: each kind's tokens
/// by how frequent they are in all.
#[derive(Clone, Debug)]
pub(in crate::codec) struct Encoder {
    kinds: usize,
    numbers: Vec<(u8, u32)>,
}

impl Encoder {
    /// For numbers of so many kinds, at most 256.
    pub(in crate::codec) const fn new(kinds: usize) -> Self {
        Self { kinds, numbers: Vec::new() }
    }

    /// Appends a number of a kind.
    pub(in crate::codec) fn push(&mut self, kind: usize, number: u32) {
        self.numbers.push((kind as u8, number));
    }

    /// The bytes of all numbers. O(numbers).
    pub(in crate::codec) fn finish(&self) -> Vec<u8> {
        let mut counts = vec![[0; TOKENS]; self.kinds];
        for &(kind, number) in &self.numbers {
            counts[usize::from(kind)][usize::from(Token::of(number).token)] += 1;
        }
        let mut bits = BitWriter::default();
        let write = |counts| Frequencies::write(counts, &mut bits);
        let frequencies: Vec<Frequencies> = counts.iter().map(write).collect();
        // Where the tokens of a kind begin among all its shares.
        let begins: Vec<[u32; TOKENS]> = frequencies
            .iter()
            .map(|Frequencies(frequencies)| {
                let mut sum = 0;
                frequencies.map(|frequency| {
                    sum += frequency;
                    sum - frequency
                })
            })
            .collect();
        for &(_, number) in &self.numbers {
            let Token { open, width, .. } = Token::of(number);
            bits.push(open, width);
        }
        let mut bytes = bits.finish();
        let mut states = [LEAST_STATE; 2];
        // What is read first is written last.
        for (index, &(kind, number)) in self.numbers.iter().enumerate().rev() {
            let (kind, token) = (usize::from(kind), usize::from(Token::of(number).token));
            let frequency = frequencies[kind].0[token];
            let state = &mut states[index % 2];
            if u64::from(*state) >= u64::from(frequency) << (32 - TOTAL_BITS) {
                bytes.extend_from_slice(&(*state as u16).to_le_bytes());
                *state >>= 16;
            }
            *state =
                (*state / frequency) << TOTAL_BITS | (*state % frequency + begins[kind][token]);
        }
        states.iter().for_each(|state| bytes.extend_from_slice(&state.to_le_bytes()));
        bytes
    }
}
