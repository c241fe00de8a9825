//! A file mapped into memory. The only unsafe code of this crate.

use std::borrow::Cow;
use std::ops::Range;
use std::path::Path;

use memmap2::Mmap;

use super::{Source, open_regular, slice};
use crate::error::{Error, Result};

/// A file's bytes, paged in as they are read: for files that nobody writes to.
///
/// Whoever shortens the file meanwhile makes the operating system end this
/// process (SIGBUS), and what others write to it can change after it was checked.
/// Writing a `.dsm` file with this crate never does either: it replaces the file and
/// leaves the mapped one alone.
#[derive(Debug)]
pub struct MappedFile(Option<Mmap>);

impl MappedFile {
    /// Maps a file.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if it cannot be opened or mapped.
    #[expect(unsafe_code, reason = "a mapping can change under its reader; see SAFETY")]
    pub fn open(path: &Path) -> Result<Self> {
        let (file, length) = open_regular(path)?;
        // Nothing to map, and not every system maps nothing.
        if length == 0 {
            return Ok(Self(None));
        }
        // SAFETY: The mapping is read only, and its bytes are used as plain
        // integers and floats, which have no invalid value. That they do not
        // change is up to whoever else can write to the file, as the caller
        // is told; this crate never writes to a file in place. What is read
        // once and used as an index or length is checked after it was read.
        let map = unsafe { Mmap::map(&file) }.map_err(Error::io("map it into memory"))?;
        Ok(Self(Some(map)))
    }
}

impl Source for MappedFile {
    fn length(&self) -> u64 {
        self.0.as_deref().unwrap_or_default().len() as u64
    }

    fn read(&self, range: Range<u64>) -> Result<Cow<'_, [u8]>> {
        slice(self.0.as_deref().unwrap_or_default(), range)
    }
}
