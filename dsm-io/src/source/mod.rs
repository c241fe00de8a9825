//! Sources of a file's bytes.

pub(crate) mod mapped;
pub(crate) mod memory;
pub(crate) mod ranges;
pub(crate) mod remote;

use std::borrow::Cow;
use std::fmt::Debug;
use std::fs::File;
use std::ops::Range;
use std::path::Path;

use crate::error::{Error, Result};

/// A file's bytes by ranges: a file, a mapping, memory, or whatever else can be asked
/// for some bytes at some offset, such as an object store. What a range answers once
/// does not change, even if the file does.
///
/// Readers ask for the prologue, the sections and the tile directories when a file
/// is opened, then for each tile that is read, one range each, and never for more
/// than a range that the file states and that lies within [`Self::length`].
///
/// ```
/// use std::borrow::Cow;
/// use std::ops::Range;
/// use dsm_io::detail::Source;
///
/// /// Bytes that somebody hands out piece by piece.
/// #[derive(Debug)]
/// struct Pieces(Vec<u8>);
///
/// impl Source for Pieces {
///     fn length(&self) -> u64 {
///         self.0.len() as u64
///     }
///
///     fn read(&self, range: Range<u64>) -> Result<Cow<'_, [u8]>, dsm_io::Error> {
///         let bytes = &self.0[range.start as usize..range.end as usize];
///         Ok(Cow::Owned(bytes.to_vec()))
///     }
/// }
/// ```
pub trait Source: Debug + Send + Sync {
    /// Length of the file in bytes.
    fn length(&self) -> u64;

    /// The bytes of a range that lies within the file: borrowed where they are in
    /// memory already, so that tiles can be used where they lie. As many as asked
    /// for; others are refused as truncated.
    ///
    /// # Errors
    ///
    /// Whatever keeps them from being read.
    fn read(&self, range: Range<u64>) -> Result<Cow<'_, [u8]>>;

    /// Ends the opening: the prologue, the sections and the directories were read. A
    /// source that fetched more for them may let it go. Nothing by default.
    fn opened(&self) {}

    /// What a user should know of how far the bytes can be relied on: one sentence
    /// without a full stop. None by default.
    fn remark(&self) -> Option<&str> {
        None
    }
}

/// Length in bytes of the file that a path or an address names.
///
/// # Errors
///
/// [`Error::File`] if there is none.
pub fn file_length(path: &Path) -> Result<u64> {
    let length = if dsm_remote::is_url(path) {
        remote::RemoteSource::open(path).map(|source| source.length())
    } else {
        path.metadata().map(|metadata| metadata.len()).map_err(Error::io("open"))
    };
    length.map_err(|error| error.in_file(path))
}

/// A range of bytes in memory.
fn slice(bytes: &[u8], range: Range<u64>) -> Result<Cow<'_, [u8]>> {
    let [start, end] = [range.start, range.end].map(usize::try_from);
    let found = start.ok().zip(end.ok()).and_then(|(start, end)| bytes.get(start..end));
    let (stated, actual) = (range.end, bytes.len() as u64);
    found.map(Cow::Borrowed).ok_or(Error::Truncated { stated, actual })
}

/// Opens a regular file and tells its length. Anything else could block
/// (pipes) or has no length.
fn open_regular(path: &Path) -> Result<(File, u64)> {
    let metadata = path.metadata().map_err(Error::io("open"))?;
    if !metadata.is_file() {
        return Err(Error::NotDsm("not a regular file"));
    }
    let file = File::open(path).map_err(Error::io("open"))?;
    // The file that was opened, not the one that had the name before.
    let length = file.metadata().map_err(Error::io("open"))?.len();
    Ok((file, length))
}
