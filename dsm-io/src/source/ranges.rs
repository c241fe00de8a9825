//! A file read range by range.

use std::borrow::Cow;
use std::fs::File;
use std::ops::Range;
use std::path::Path;

use super::{Source, open_regular};
use crate::error::{Error, Result};

/// A file's bytes, read into memory of the reader's own as they are asked for: what
/// was checked is what is used, whatever others write to the file meanwhile.
#[derive(Debug)]
pub struct FileRanges {
    file: File,
    length: u64,
}

impl FileRanges {
    /// Opens a file.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if it cannot be opened.
    pub fn open(path: &Path) -> Result<Self> {
        let (file, length) = open_regular(path)?;
        Ok(Self { file, length })
    }
}

impl Source for FileRanges {
    fn length(&self) -> u64 {
        self.length
    }

    fn read(&self, range: Range<u64>) -> Result<Cow<'_, [u8]>> {
        let truncated = Error::Truncated { stated: range.end, actual: self.length };
        let length = range.end.checked_sub(range.start).filter(|_| range.end <= self.length);
        let Some(length) = length.and_then(|length| usize::try_from(length).ok()) else {
            return Err(truncated);
        };
        let mut bytes = Vec::new();
        if bytes.try_reserve_exact(length).is_err() {
            return Err(Error::Io {
                action: "read",
                error: std::io::ErrorKind::OutOfMemory.into(),
            });
        }
        bytes.resize(length, 0);
        match read_exact_at(&self.file, &mut bytes, range.start) {
            // Cut after it was opened.
            Err(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => {
                let actual = self.file.metadata().map_err(Error::io("read"))?.len();
                Err(Error::Truncated { stated: range.end, actual })
            }
            read => read.map(|()| Cow::Owned(bytes)).map_err(Error::io("read")),
        }
    }
}

/// Fills `bytes` from an offset, without the file's cursor, which threads share.
#[cfg(unix)]
fn read_exact_at(file: &File, bytes: &mut [u8], offset: u64) -> std::io::Result<()> {
    std::os::unix::fs::FileExt::read_exact_at(file, bytes, offset)
}

/// Fills `bytes` from an offset. Every read here says where it starts.
#[cfg(windows)]
fn read_exact_at(file: &File, mut bytes: &mut [u8], mut offset: u64) -> std::io::Result<()> {
    use std::io::ErrorKind;
    while !bytes.is_empty() {
        match std::os::windows::fs::FileExt::seek_read(file, bytes, offset) {
            Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
            Ok(count) => {
                bytes = &mut bytes[count..];
                offset += count as u64;
            }
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn file(bytes: &[u8]) -> tempfile::NamedTempFile {
        let mut file = tempfile::NamedTempFile::new().unwrap();
        file.write_all(bytes).unwrap();
        file
    }

    #[test]
    fn ranges_are_those_of_the_file() {
        let bytes: Vec<u8> = (0..=255).collect();
        let file = file(&bytes);
        let source = FileRanges::open(file.path()).unwrap();
        assert_eq!(source.length(), 256);
        assert_eq!(&*source.read(17..40).unwrap(), &bytes[17..40]);
        assert!(source.read(256..256).unwrap().is_empty());
        for outside in [250..257, u64::MAX - 1..u64::MAX] {
            let refused = source.read(outside).unwrap_err();
            assert!(matches!(refused, Error::Truncated { .. }), "{refused}");
        }
    }

    #[test]
    fn what_was_read_stays_and_a_cut_is_an_error() {
        let file = file(&[7; 100]);
        let source = FileRanges::open(file.path()).unwrap();
        let read = source.read(0..100).unwrap();
        file.as_file().set_len(40).unwrap();
        assert_eq!(&*read, &[7; 100]);
        let refused = source.read(10..60).unwrap_err();
        assert!(matches!(refused, Error::Truncated { stated: 60, actual: 40 }), "{refused}");
        assert_eq!(&*source.read(10..40).unwrap(), &[7; 30]);
    }
}
