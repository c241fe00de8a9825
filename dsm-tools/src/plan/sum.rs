//! A sum over bytes, by which files are told apart (Fowler, Noll & Vo's FNV-1a, 64 bits).

use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::path::Path;

/// A running sum.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sum(u64);

impl Sum {
    pub(crate) const fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    /// Adds bytes.
    pub(crate) fn add(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    /// The sum in 16 digits.
    pub(crate) fn text(self) -> String {
        format!("{:016x}", self.0)
    }

    /// The sum of a file's bytes.
    pub(crate) fn of_file(path: &Path) -> io::Result<String> {
        let mut reader = BufReader::with_capacity(1 << 20, File::open(path)?);
        let mut sum = Self::new();
        loop {
            let bytes = reader.fill_buf()?;
            if bytes.is_empty() {
                return Ok(sum.text());
            }
            sum.add(bytes);
            let length = bytes.len();
            reader.consume(length);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_those_of_the_definition() {
        for (text, expected) in [("", "cbf29ce484222325"), ("a", "af63dc4c8601ec8c")] {
            let mut sum = Sum::new();
            sum.add(text.as_bytes());
            assert_eq!(sum.text(), expected);
        }
    }
}
