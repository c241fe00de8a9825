//! A file held in memory.

use std::borrow::Cow;
use std::io::Read;
use std::ops::Range;
use std::path::Path;

use super::{Source, open_regular, slice};
use crate::error::check_limit;
use crate::error::{Error, Result};

/// A file's bytes in memory: nothing that happens to the file matters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Memory(Vec<u8>);

impl Memory {
    /// Reads a file of at most `limit` bytes.
    ///
    /// # Errors
    ///
    /// [`Error::Limit`], or [`Error::Io`] if it cannot be read.
    pub fn read(path: &Path, limit: u64) -> Result<Self> {
        let (file, length) = open_regular(path)?;
        check_limit("bytes of a file in memory", length, limit)?;
        let mut bytes = Vec::new();
        let reserved = usize::try_from(length).map(|length| bytes.try_reserve_exact(length));
        if !matches!(reserved, Ok(Ok(()))) {
            return Err(Error::Io {
                action: "read it into memory",
                error: std::io::ErrorKind::OutOfMemory.into(),
            });
        }
        file.take(length).read_to_end(&mut bytes).map_err(Error::io("read"))?;
        Ok(Self(bytes))
    }
}

impl From<Vec<u8>> for Memory {
    fn from(bytes: Vec<u8>) -> Self {
        Self(bytes)
    }
}

impl Source for Memory {
    fn length(&self) -> u64 {
        self.0.len() as u64
    }

    fn read(&self, range: Range<u64>) -> Result<Cow<'_, [u8]>> {
        slice(&self.0, range)
    }
}
