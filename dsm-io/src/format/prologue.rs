//! The 64 bytes that every file begins with.

use super::extent::{Extent, checksum};
use super::section::SECTION_ENTRY_BYTES;
use super::version::{MAGIC, MAJOR, MINOR, check_magic};
use super::{field, put, reserved_is_valid, u32_at, u64_at};
use crate::error::{Error, Place, Result};

/// Length of the prologue, in bytes.
pub(super) const PROLOGUE_BYTES: usize = 64;

/// Flags that a reader must know to read the file; it may ignore the others.
const REQUIRED_FLAGS: u32 = 0x0000_FFFF;

/// Where the checksum of the bytes before it stands.
const CRC_AT: usize = 60;

/// The decoded prologue.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prologue {
    /// The file's minor version.
    pub(super) minor: u16,
    /// The file's length, in bytes.
    pub(super) file_length: u64,
    /// Where the section table stands.
    pub(super) table: Extent,
    /// Number of sections.
    pub(super) section_count: u32,
}

impl Prologue {
    pub(super) fn encode(&self) -> [u8; PROLOGUE_BYTES] {
        let mut bytes = [0; PROLOGUE_BYTES];
        put(&mut bytes, 0, MAGIC);
        put(&mut bytes, 8, MAJOR.to_le_bytes());
        put(&mut bytes, 10, self.minor.to_le_bytes());
        put(&mut bytes, 16, self.file_length.to_le_bytes());
        put(&mut bytes, 24, self.table.offset.to_le_bytes());
        put(&mut bytes, 32, self.section_count.to_le_bytes());
        put(&mut bytes, 36, self.table.crc.to_le_bytes());
        let crc = checksum(&[&bytes[..CRC_AT]]);
        put(&mut bytes, CRC_AT, crc.to_le_bytes());
        bytes
    }

    /// Reads the prologue of a file of `actual` bytes of which `file` holds
    /// the first.
    pub(super) fn decode(file: &[u8], actual: u64) -> Result<Self> {
        let place = Place::Prologue;
        check_magic(file)?;
        if file.len() < PROLOGUE_BYTES {
            return Err(Error::Truncated { stated: PROLOGUE_BYTES as u64, actual });
        }
        // The layout of another major version is unknown, so its checksum is.
        let [major, minor] = [8, 10].map(|at| u16::from_le_bytes(field(file, at)));
        if major != MAJOR {
            return Err(Error::Version { major, minor });
        }
        let (stored, computed) = (u32_at(file, CRC_AT), checksum(&[&file[..CRC_AT]]));
        if stored != computed {
            return Err(Error::Checksum { place, stored, computed });
        }
        let flags = u32_at(file, 12);
        if flags & REQUIRED_FLAGS != 0 {
            return Err(Error::Unsupported { place, what: format!("flag {flags:#010x}") });
        }
        if !reserved_is_valid(&file[40..CRC_AT], minor) || (minor == MINOR && flags != 0) {
            return Err(Error::invalid(place, "reserved bytes are not zero"));
        }
        let stated = u64_at(file, 16);
        if stated > actual {
            return Err(Error::Truncated { stated, actual });
        }
        if stated < actual {
            return Err(Error::Trailing { stated, actual });
        }
        let section_count = u32_at(file, 32);
        let length = u64::from(section_count) * SECTION_ENTRY_BYTES as u64;
        let table = Extent { offset: u64_at(file, 24), length, crc: u32_at(file, 36) };
        Ok(Self { minor, file_length: stated, table, section_count })
    }

    /// What the prologue itself covers.
    pub(super) const fn extent() -> Extent {
        Extent { offset: 0, length: PROLOGUE_BYTES as u64, crc: 0 }
    }
}
