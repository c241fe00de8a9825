//! Checked reads of little-endian numbers.

use crate::error::{Error, Place, Result};

/// A place in a file's bytes.
#[derive(Clone, Copy)]
pub(super) struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    pub(super) fn new(bytes: &'a [u8], at: u64) -> Result<Self> {
        match usize::try_from(at) {
            Ok(at) if at <= bytes.len() => Ok(Self { bytes, at }),
            _ => Err(Error::malformed(Place::Byte(at), "beyond the end of the file")),
        }
    }

    pub(super) fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    pub(super) fn error(&self, reason: &'static str) -> Error {
        Error::malformed(Place::Byte(self.at as u64), reason)
    }

    pub(super) fn take(&mut self, count: u64) -> Result<&'a [u8]> {
        let end = usize::try_from(count).ok().and_then(|count| self.at.checked_add(count));
        match end.and_then(|end| self.bytes.get(self.at..end)) {
            Some(taken) => {
                self.at += taken.len();
                Ok(taken)
            }
            None => Err(self.error("truncated")),
        }
    }

    pub(super) fn array<const N: usize>(&mut self) -> Result<[u8; N]> {
        let mut taken = [0; N];
        taken.copy_from_slice(self.take(N as u64)?);
        Ok(taken)
    }

    pub(super) fn u8(&mut self) -> Result<u8> {
        Ok(self.array::<1>()?[0])
    }

    pub(super) fn u32(&mut self) -> Result<u32> {
        self.array().map(u32::from_le_bytes)
    }

    pub(super) fn u64(&mut self) -> Result<u64> {
        self.array().map(u64::from_le_bytes)
    }

    pub(super) fn f64(&mut self) -> Result<f64> {
        self.array().map(f64::from_le_bytes)
    }

    /// The number of items that follow, each of at least `size` bytes.
    pub(super) fn count(&mut self, size: u64) -> Result<u64> {
        let count = self.u64()?;
        if count.checked_mul(size).is_none_or(|bytes| bytes > self.left() as u64) {
            return Err(self.error("more items are stated than the file has bytes for"));
        }
        Ok(count)
    }

    /// Where the distance that follows leads, counted from its own place.
    pub(super) fn jump(&mut self) -> Result<Self> {
        let start = self.at as u64;
        let distance = self.array().map(i64::from_le_bytes)?;
        match start.checked_add_signed(distance) {
            Some(at) => Self::new(self.bytes, at),
            None => Err(self.error("a jump out of the file")),
        }
    }
}
