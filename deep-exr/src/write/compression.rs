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
    /// Zstandard, new in OpenEXR 3.5: older readers refuse it.
    Zstd,
    /// Not at all.
    None,
}

impl Compression {
    pub(crate) const fn packing(self) -> Packing {
        match self {
            Self::Zips => Packing::Zips,
            Self::Rle => Packing::Rle,
            Self::Zstd => Packing::Zstd,
            Self::None => Packing::None,
        }
    }
}
