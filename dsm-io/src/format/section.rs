//! Sections: the parts of a file besides its tiles.

use super::extent::Extent;
use super::{field, put, reserved_is_valid, u32_at, u64_at};
use crate::error::{Error, Place, Result};
use crate::section_kind::SectionKind;

/// Length of an entry of the section table, in bytes.
pub(super) const SECTION_ENTRY_BYTES: usize = 32;

/// The flag of sections that a reader must know.
const REQUIRED: u32 = 1;

/// An entry of the section table.
#[derive(Clone, Copy, Debug)]
pub(super) struct Section {
    pub(super) kind: SectionKind,
    pub(super) required: bool,
    pub(super) extent: Extent,
}

impl Section {
    pub(super) fn encode(&self) -> [u8; SECTION_ENTRY_BYTES] {
        let mut bytes = [0; SECTION_ENTRY_BYTES];
        put(&mut bytes, 0, self.kind.0);
        put(&mut bytes, 4, (if self.required { REQUIRED } else { 0 }).to_le_bytes());
        put(&mut bytes, 8, self.extent.offset.to_le_bytes());
        put(&mut bytes, 16, self.extent.length.to_le_bytes());
        put(&mut bytes, 24, self.extent.crc.to_le_bytes());
        bytes
    }

    /// Reads entry `index` of a file of `file_length` bytes.
    pub(super) fn decode(bytes: &[u8], index: u32, minor: u16, file_length: u64) -> Result<Self> {
        let kind = SectionKind(field(bytes, 0));
        let place = Place::Section { index, kind };
        let flags = u32_at(bytes, 4);
        let required = flags & REQUIRED != 0;
        if required && !kind.is_known() {
            return Err(Error::Unsupported { place, what: format!("section \"{kind}\"") });
        }
        if kind.is_known() && !required {
            return Err(Error::invalid(place, "its flag \"required\" is not set"));
        }
        if !reserved_is_valid(&bytes[28..], minor)
            || !reserved_is_valid(&(flags & !REQUIRED).to_le_bytes(), minor)
        {
            return Err(Error::invalid(place, "reserved bits are not zero"));
        }
        let extent =
            Extent { offset: u64_at(bytes, 8), length: u64_at(bytes, 16), crc: u32_at(bytes, 24) };
        extent.check_inside(file_length, place)?;
        Ok(Self { kind, required, extent })
    }

    pub(super) const fn place(&self, index: u32) -> Place {
        Place::Section { index, kind: self.kind }
    }
}
