//! Bits, the lowest of a byte first.

/// Bits as they are written.
#[derive(Clone, Debug, Default)]
pub(super) struct BitWriter {
    bytes: Vec<u8>,
    /// What has no byte yet, and how many bits that is, less than 8.
    rest: u64,
    held: u32,
}

impl BitWriter {
    /// Appends the `width` low bits of a number, all that it has, at most 32.
    pub(super) fn push(&mut self, number: u32, width: u32) {
        self.rest |= u64::from(number) << self.held;
        self.held += width;
        while self.held >= 8 {
            self.bytes.push(self.rest as u8);
            self.rest >>= 8;
            self.held -= 8;
        }
    }

    /// Appends a number in about twice as many bits as it has (Elias 1975, γ of one more).
    pub(super) fn push_gamma(&mut self, number: u32) {
        let width = (number + 1).ilog2();
        self.push(0, width);
        self.push(1, 1);
        self.push((number + 1) & !(1 << width), width);
    }

    /// Whole bytes.
    pub(super) fn finish(mut self) -> Vec<u8> {
        self.push(0, self.held.wrapping_neg() % 8);
        self.bytes
    }
}

/// Bits as they are read: zeros behind the end.
#[derive(Clone, Debug)]
pub(super) struct BitReader<'a> {
    bytes: &'a [u8],
    position: usize,
}

impl<'a> BitReader<'a> {
    pub(super) const fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, position: 0 }
    }

    /// The next `width` bits, at most 32.
    #[inline(always)]
    pub(super) fn take(&mut self, width: u32) -> u32 {
        let byte = self.position / 8;
        let word = match self.bytes.get(byte..byte + 8).and_then(|bytes| bytes.try_into().ok()) {
            Some(bytes) => u64::from_le_bytes(bytes),
            None => self.last_word(byte),
        };
        let bits = word >> (self.position % 8) & ((1 << width) - 1);
        self.position += width as usize;
        bits as u32
    }

    #[cold]
    fn last_word(&self, byte: usize) -> u64 {
        let rest = self.bytes.get(byte..).unwrap_or(&[]);
        rest.iter().rev().fold(0, |word, &byte| word << 8 | u64::from(byte))
    }

    /// A number as [`BitWriter::push_gamma`] writes it, if it is below 2¹⁶.
    pub(super) fn take_gamma(&mut self) -> Option<u32> {
        let width = (0..16).take_while(|_| self.take(1) == 0).count() as u32;
        // The one that ends the zeros was taken with them.
        if width == 16 {
            return None;
        }
        Some((1 << width | self.take(width)) - 1)
    }

    /// Number of bytes that were begun, if the rest of the last is zeros.
    pub(super) fn end(&mut self) -> Option<usize> {
        let rest = self.position.wrapping_neg() % 8;
        (self.take(rest as u32) == 0).then_some(self.position / 8)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_come_back() {
        let mut writer = BitWriter::default();
        for width in 0..=32 {
            writer.push(((0x9e37_79b9_u64 << width >> 32) & ((1 << width) - 1)) as u32, width);
            writer.push_gamma(width * width);
        }
        let bytes = writer.finish();
        let mut reader = BitReader::new(&bytes);
        for width in 0..=32 {
            let expected = (0x9e37_79b9_u64 << width >> 32) & ((1 << width) - 1);
            assert_eq!(u64::from(reader.take(width)), expected);
            assert_eq!(reader.take_gamma(), Some(width * width));
        }
        assert_eq!(reader.end(), Some(bytes.len()));
        assert_eq!(reader.take(32), 0);
        assert_eq!(reader.take_gamma(), None);
        let mut open = BitReader::new(&[0b1000_0001]);
        open.take(3);
        assert_eq!(open.end(), None);
    }
}
