//! How written chunks are compressed.

use crate::codec::packing::Packing;

/// Compression of a written image's chunks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Compression {
    /// Deflate, a scan line or tile at a time.
    #[default]
    Zips,
    /// Run lengths.
    Rle,
    /// Not at all.
    None,
}

impl Compression {
    pub(crate) const fn packing(self) -> Packing {
        match self {
            Self::Zips => Packing::Zips,
            Self::Rle => Packing::Rle,
            Self::None => Packing::None,
        }
    }
}
