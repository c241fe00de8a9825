//! The bytes of a file, on disk or in memory.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use crate::error::{Error, Result};

/// Chunks usually follow each other: one read serves several.
const READ_AHEAD: u64 = 64 * 1024;

/// A file of known length, handed out in slices.
pub(super) struct ByteSource {
    storage: Storage,
    length: u64,
    window: Vec<u8>,
    window_start: u64,
}

enum Storage {
    File(File),
    Memory(Box<dyn AsRef<[u8]> + Send + Sync>),
}

impl ByteSource {
    pub(super) fn open(path: &Path) -> Result<Self> {
        let fail = |source| Error::Open { path: path.to_owned(), source };
        let file = File::open(path).map_err(fail)?;
        let metadata = file.metadata().map_err(fail)?;
        if metadata.is_dir() {
            return Err(fail(std::io::ErrorKind::IsADirectory.into()));
        }
        Ok(Self::new(Storage::File(file), metadata.len()))
    }

    pub(super) fn from_bytes(bytes: Box<dyn AsRef<[u8]> + Send + Sync>) -> Self {
        let length = (*bytes).as_ref().len() as u64;
        Self::new(Storage::Memory(bytes), length)
    }

    fn new(storage: Storage, length: u64) -> Self {
        Self { storage, length, window: Vec::new(), window_start: 0 }
    }

    pub(super) fn length(&self) -> u64 {
        self.length
    }

    /// The `length` bytes from `offset` on. Never takes more memory than the
    /// file is long.
    pub(super) fn slice(&mut self, offset: u64, length: u64, what: &'static str) -> Result<&[u8]> {
        if offset.checked_add(length).is_none_or(|end| end > self.length) {
            return Err(Error::Truncated { what, offset, length, file_length: self.length });
        }
        let file = match &mut self.storage {
            Storage::Memory(bytes) => {
                // Bytes that got fewer since they were given are a file cut off.
                let bytes = (**bytes).as_ref().get(offset as usize..);
                let slice = bytes.and_then(|bytes| bytes.get(..length as usize));
                let file_length = self.length;
                return slice.ok_or(Error::Truncated { what, offset, length, file_length });
            }
            Storage::File(file) => file,
        };
        let window_end = self.window_start + self.window.len() as u64;
        if offset < self.window_start || offset + length > window_end {
            let wanted = length.max(READ_AHEAD).min(self.length - offset) as usize;
            self.window.resize(wanted, 0);
            self.window_start = offset;
            let read =
                file.seek(SeekFrom::Start(offset)).and_then(|_| file.read_exact(&mut self.window));
            if let Err(source) = read {
                self.window.clear();
                return Err(Error::Read { offset, length: wanted, source });
            }
        }
        let start = (offset - self.window_start) as usize;
        Ok(&self.window[start..start + length as usize])
    }

    /// The bytes from `offset` up to a zero, at most `most` of them.
    pub(super) fn text(
        &mut self,
        offset: u64,
        most: u64,
        what: &'static str,
    ) -> Result<Option<Vec<u8>>> {
        let available = self.length.saturating_sub(offset).min(most + 1);
        let bytes = self.slice(offset, available, what)?;
        match bytes.iter().position(|&byte| byte == 0) {
            Some(end) => Ok(Some(bytes[..end].to_vec())),
            None if available <= most => Err(Error::Truncated {
                what,
                offset,
                length: available + 1,
                file_length: self.length,
            }),
            None => Ok(None),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_read_in_any_order_like_memory() {
        let bytes: Vec<u8> =
            (0..200_000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), &bytes).unwrap();
        let mut on_disk = ByteSource::open(file.path()).unwrap();
        let mut in_memory = ByteSource::from_bytes(Box::new(bytes.clone()));
        let longest = READ_AHEAD + 9;
        for (offset, length) in [
            (150_000, 10),
            (3, 5),
            (100, longest),
            (99, 2),
            (70_000, 4),
            (199_990, 10),
            (200_000, 0),
        ] {
            let wanted = &bytes[offset as usize..(offset + length) as usize];
            assert_eq!(on_disk.slice(offset, length, "").unwrap(), wanted, "{offset}");
            assert_eq!(in_memory.slice(offset, length, "").unwrap(), wanted, "{offset}");
        }
        for (offset, length) in [(199_990, 11), (200_001, 0), (u64::MAX, 2), (2, u64::MAX)] {
            for source in [&mut on_disk, &mut in_memory] {
                let error = source.slice(offset, length, "it").unwrap_err();
                assert!(matches!(error, Error::Truncated { what: "it", .. }), "{error}");
            }
        }
    }

    #[test]
    fn texts_end_with_a_zero_in_time() {
        let mut source = ByteSource::from_bytes(Box::new(*b"abc\0def"));
        assert_eq!(source.text(0, 3, "name").unwrap(), Some(b"abc".to_vec()));
        assert_eq!(source.text(3, 9, "name").unwrap(), Some(Vec::new()));
        assert_eq!(source.text(0, 2, "name").unwrap(), None);
        assert!(matches!(source.text(4, 9, "name"), Err(Error::Truncated { .. })));
    }
}
