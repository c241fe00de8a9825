//! A file's bytes in order, never beyond the end.

use crate::error::{Error, Place, Result};

/// A place in a file that nothing is read beyond the end of.
#[derive(Clone, Copy)]
pub(super) struct Bytes<'a> {
    all: &'a [u8],
    at: usize,
}

impl<'a> Bytes<'a> {
    /// The start of the file.
    pub(super) const fn new(all: &'a [u8]) -> Self {
        Self { all, at: 0 }
    }

    /// An error at the next byte.
    pub(super) fn refuse(&self, reason: impl Into<std::borrow::Cow<'static, str>>) -> Error {
        Error::malformed(Place::Byte(self.at as u64), reason)
    }

    /// The next `count` bytes.
    pub(super) fn take(&mut self, count: usize) -> Result<&'a [u8]> {
        let left = &self.all[self.at..];
        let Some(taken) = left.get(..count) else {
            let reason = format!("truncated: {count} bytes expected, {} left", left.len());
            return Err(self.refuse(reason));
        };
        self.at += count;
        Ok(taken)
    }

    /// The file at another offset.
    pub(super) fn at(self, at: u64) -> Result<Self> {
        match usize::try_from(at) {
            Ok(at) if at <= self.all.len() => Ok(Self { at, ..self }),
            _ => {
                let length = self.all.len();
                Err(self.refuse(format!("offset {at} is outside the file of {length} bytes")))
            }
        }
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N]> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N)?);
        Ok(array)
    }

    pub(super) fn u8(&mut self) -> Result<u8> {
        Ok(self.array::<1>()?[0])
    }

    pub(super) fn u32(&mut self) -> Result<u32> {
        self.array().map(u32::from_le_bytes)
    }

    pub(super) fn i32(&mut self) -> Result<i32> {
        self.array().map(i32::from_le_bytes)
    }

    pub(super) fn u64(&mut self) -> Result<u64> {
        self.array().map(u64::from_le_bytes)
    }

    pub(super) fn i64(&mut self) -> Result<i64> {
        self.array().map(i64::from_le_bytes)
    }

    pub(super) fn f64(&mut self) -> Result<f64> {
        self.array().map(f64::from_le_bytes)
    }

    /// A text after its length.
    pub(super) fn text(&mut self) -> Result<String> {
        let length = self.u32()?;
        Ok(String::from_utf8_lossy(self.take(length as usize)?).into_owned())
    }
}
