//! Runs of bytes under one checksum, which tile the file without gaps.

use std::borrow::Cow;

use crc_fast::{CrcAlgorithm, Digest};

use crate::error::Place;
use crate::error::{Error, Result};
use crate::source::Source;

/// Every extent begins at a multiple of this, in bytes: a cache line.
pub(super) const ALIGNMENT: u64 = 64;

/// What an extent is filled up with; the checksum covers it.
const PADDING: [u8; ALIGNMENT as usize] = [0; ALIGNMENT as usize];

/// The zeros that follow `length` bytes.
pub(super) fn padding(length: u64) -> &'static [u8] {
    &PADDING[..(length.next_multiple_of(ALIGNMENT) - length) as usize]
}

/// CRC-32C (Castagnoli) of all parts, one after the other.
pub(super) fn checksum(parts: &[&[u8]]) -> u32 {
    let mut digest = Digest::new(CrcAlgorithm::Crc32Iscsi);
    parts.iter().for_each(|part| digest.update(part));
    // A 32-bit checksum in a 64-bit word.
    digest.finalize() as u32
}

/// A run of bytes of the file, padded with zeros to the next multiple of
/// [`ALIGNMENT`].
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Extent {
    /// Where it begins in the file, in bytes.
    pub(super) offset: u64,
    /// Its length in bytes, without padding.
    pub(super) length: u64,
    /// CRC-32C of its bytes and padding.
    pub(super) crc: u32,
}

impl Extent {
    /// Where the next extent may begin, unless that is past any file.
    fn end(self) -> Option<u64> {
        self.offset.checked_add(self.length)?.checked_next_multiple_of(ALIGNMENT)
    }

    /// Refuses an extent that is not aligned or not wholly in a file of
    /// `file_length` bytes.
    pub(super) fn check_inside(self, file_length: u64, place: Place) -> Result<()> {
        if !self.offset.is_multiple_of(ALIGNMENT) {
            return Err(Error::invalid(
                place,
                format!("its offset {} is not a multiple of {ALIGNMENT}", self.offset),
            ));
        }
        match self.end() {
            Some(end) if end <= file_length => Ok(()),
            _ => Err(Error::invalid(
                place,
                format!(
                    "{} bytes at byte {} do not lie in a file of {file_length} bytes",
                    self.length, self.offset
                ),
            )),
        }
    }

    /// The extent's bytes, once its checksum and padding are found right.
    pub(super) fn bytes(self, file: &dyn Source, place: Place) -> Result<Cow<'_, [u8]>> {
        self.check_inside(file.length(), place)?;
        // It lies in the file, so the sums are not above the file's length.
        let padded = self.length.next_multiple_of(ALIGNMENT);
        let end = self.offset + padded;
        let mut bytes = file.read(self.offset..end)?;
        if bytes.len() as u64 != padded {
            let actual = self.offset + bytes.len() as u64;
            return Err(Error::Truncated { stated: end, actual });
        }
        let computed = checksum(&[&bytes]);
        if computed != self.crc {
            return Err(Error::Checksum { place, stored: self.crc, computed });
        }
        let length = self.length as usize;
        if bytes[length..].iter().any(|&byte| byte != 0) {
            return Err(Error::invalid(place, "its padding is not zero"));
        }
        match &mut bytes {
            Cow::Borrowed(bytes) => *bytes = &bytes[..length],
            Cow::Owned(bytes) => bytes.truncate(length),
        }
        Ok(bytes)
    }
}

/// Refuses extents that leave a byte of the file uncovered or cover one
/// twice. Each was found inside the file before. O(n log n).
pub(super) fn check_cover(mut extents: Vec<(Extent, Place)>, file_length: u64) -> Result<()> {
    extents.sort_unstable_by_key(|(extent, _)| (extent.offset, extent.length));
    let mut covered = 0;
    for (extent, place) in extents {
        if extent.offset < covered {
            return Err(Error::invalid(place, "it overlaps another part of the file"));
        }
        if extent.offset > covered {
            let place = Place::Bytes { start: covered, end: extent.offset };
            return Err(Error::invalid(place, "no part of the file claims them"));
        }
        covered = extent.end().unwrap_or(file_length);
    }
    if covered == file_length {
        Ok(())
    } else {
        let place = Place::Bytes { start: covered, end: file_length };
        Err(Error::invalid(place, "no part of the file claims them"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cover(extents: &[(u64, u64)], length: u64) -> Result<()> {
        let extent = |&(offset, length): &(u64, u64)| {
            (Extent { offset, length, crc: 0 }, Place::SectionTable)
        };
        check_cover(extents.iter().map(extent).collect(), length)
    }

    #[test]
    fn extents_cover_the_file_once() {
        assert!(cover(&[(128, 1), (0, 64), (64, 60)], 192).is_ok());
        assert!(cover(&[(0, 64), (64, 0), (64, 64), (128, 0)], 128).is_ok());
        for (wrong, length) in [
            (&[(64, 64)][..], 128),
            (&[(0, 64)], 128),
            (&[(0, 64), (128, 64)], 192),
            (&[(0, 65), (64, 64)], 128),
            (&[(0, 64), (64, 128), (128, 0)], 192),
            (&[(0, 64), (0, 64)], 64),
        ] {
            assert!(cover(wrong, length).is_err(), "{wrong:?}");
        }
    }

    #[test]
    fn extents_past_the_end_are_refused_without_overflow() {
        for (offset, length) in [(64, 1), (0, 65), (1, 1), (u64::MAX - 63, 1), (64, u64::MAX)] {
            let extent = Extent { offset, length, crc: 0 };
            assert!(extent.check_inside(64, Place::Prologue).is_err(), "{offset} {length}");
        }
    }

    #[test]
    fn padding_fills_up() {
        assert_eq!([0, 1, 63, 64, 65].map(|length| padding(length).len()), [0, 63, 1, 0, 63]);
    }
}
