//! Names of sections.

use std::fmt;

/// Four characters of ASCII that name what a section holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct SectionKind(pub [u8; 4]);

impl SectionKind {
    /// The metadata: one JSON object.
    pub const METADATA: Self = Self(*b"META");
    /// The records of all levels.
    pub const LEVELS: Self = Self(*b"LEVL");
    /// The tile directory of one level.
    pub const DIRECTORY: Self = Self(*b"TDIR");

    /// Whether this program knows what such a section holds.
    pub(crate) const fn is_known(self) -> bool {
        matches!(self, Self::METADATA | Self::LEVELS | Self::DIRECTORY)
    }
}

impl fmt::Display for SectionKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0.escape_ascii())
    }
}
