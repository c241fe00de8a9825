//! USDZ: a ZIP archive of files that are not compressed.

use std::ops::Range;

use crate::error::{Error, Place, Result};

const END: &[u8] = b"PK\x05\x06";
const ENTRY: &[u8] = b"PK\x01\x02";
const LOCAL: &[u8] = b"PK\x03\x04";

/// The files in an archive.
pub(super) struct Archive {
    bytes: Vec<u8>,
    members: Vec<(String, Range<usize>)>,
}

impl Archive {
    pub(super) fn read(bytes: Vec<u8>) -> Result<Self> {
        let malformed = |at: usize, reason| Error::malformed(Place::Byte(at as u64), reason);
        // The end has a comment of up to 65,535 bytes after it.
        let first = bytes.len().saturating_sub(22 + 65_535);
        let end = (first..bytes.len()).rev().find(|&at| bytes[at..].starts_with(END));
        let end = end.ok_or_else(|| malformed(0, "not a USDZ archive, or truncated"))?;
        let half = |at: usize| -> Result<usize> {
            let found = bytes.get(at..).and_then(|rest| rest.first_chunk::<2>());
            found
                .map(|&half| u16::from_le_bytes(half).into())
                .ok_or_else(|| malformed(at, "the archive is truncated"))
        };
        let word = |at: usize| Ok::<_, Error>(half(at)? | half(at + 2)? << 16);
        let mut members = Vec::new();
        let mut at = word(end + 16)?;
        for _ in 0..half(end + 10)? {
            if !bytes.get(at..).is_some_and(|rest| rest.starts_with(ENTRY)) {
                return Err(malformed(at, "an entry of the archive is missing"));
            }
            let (flags, method, size) = (half(at + 8)?, half(at + 10)?, word(at + 20)?);
            let (name, extra, comment) = (half(at + 28)?, half(at + 30)?, half(at + 32)?);
            let local = word(at + 42)?;
            let name_bytes = bytes.get(at + 46..at + 46 + name);
            let name_bytes = name_bytes.ok_or_else(|| malformed(at, "the archive is truncated"))?;
            let name_text = String::from_utf8_lossy(name_bytes).into_owned();
            if !bytes.get(local..).is_some_and(|rest| rest.starts_with(LOCAL)) {
                return Err(malformed(at, "a file of the archive is missing"));
            }
            let start = local + 30 + half(local + 26)? + half(local + 28)?;
            let data = start..start.saturating_add(size);
            if bytes.get(data.clone()).is_none() {
                return Err(malformed(at, "a file of the archive is truncated"));
            }
            if method != 0 || flags & 1 != 0 {
                return Err(malformed(at, "a file of the archive is compressed or encrypted"));
            }
            members.push((name_text, data));
            at += 46 + name + extra + comment;
        }
        Ok(Self { bytes, members })
    }

    /// The file that the archive stands for: its first.
    pub(super) fn root(&self) -> Option<&str> {
        self.members.first().map(|member| member.0.as_str())
    }

    pub(super) fn member(&self, name: &str) -> Option<&[u8]> {
        let found = self.members.iter().find(|member| member.0 == name)?;
        self.bytes.get(found.1.clone())
    }
}
