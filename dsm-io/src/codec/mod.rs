//! Codecs between the pixels of a tile and bytes.
//!
//! A codec turns pixels into columns of 32-bit words; a packing shrinks the
//! columns. Both are named in the tile's directory entry.

mod entropy;
pub(crate) mod exact;
mod grids;
mod packed;
pub(crate) mod quantized;
mod stations;
pub(crate) mod stored_tile;
pub(crate) mod tile_columns;
mod words;

use dsm_core::Transmittance;
use dsm_core::detail::PixelListsView;

use crate::error::Result;
use crate::format::encoded_tile::EncodedTile;

/// The encoding of columns.
///
/// ```
/// use dsm_io::Codec;
///
/// assert_eq!(Codec::from_tag(1).map(Codec::name), Some("quantized"));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Codec {
    /// Depths and values as they are in memory, `f32`.
    #[default]
    Exact,
    /// The small numbers that depths and values are on the grids that they were
    /// rounded to ([`dsm_core::detail::Quantization`]). A tile whose values lie on no
    /// grid is stored as [`Self::Exact`].
    Quantized,
}

impl Codec {
    /// The codec's number in the file.
    pub(crate) const fn tag(self) -> u8 {
        match self {
            Self::Exact => 0,
            Self::Quantized => 1,
        }
    }

    /// The codec with this number in the file, if it is known.
    #[must_use]
    pub const fn from_tag(tag: u8) -> Option<Self> {
        match tag {
            0 => Some(Self::Exact),
            1 => Some(Self::Quantized),
            _ => None,
        }
    }

    /// The codec's name, as the command line spells it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Quantized => "quantized",
        }
    }
}

/// The packing of encoded columns.
///
/// ```
/// use dsm_io::Packing;
///
/// assert_eq!(Packing::from_tag(0).map(Packing::name), Some("none"));
/// assert!(Packing::from_tag(200).is_none());
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Packing {
    /// Unpacked columns: an exact tile can be used where it lies.
    #[default]
    Plain,
    /// Their bytes shuffled by significance in a zstd frame; what lies on grids as
    /// [`Self::Entropy`].
    Zstd,
    /// Numbers on grids as few bits, by how frequent they are. What lies on no grid is
    /// packed as [`Self::Zstd`].
    Entropy,
}

impl Packing {
    /// The packing's number in the file.
    pub(crate) const fn tag(self) -> u8 {
        match self {
            Self::Plain => 0,
            Self::Zstd => 1,
            Self::Entropy => 2,
        }
    }

    /// The packing with this number in the file, if it is known.
    #[must_use]
    pub const fn from_tag(tag: u8) -> Option<Self> {
        match tag {
            0 => Some(Self::Plain),
            1 => Some(Self::Zstd),
            2 => Some(Self::Entropy),
            _ => None,
        }
    }

    /// The packing's name, as the command line spells it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Plain => "none",
            Self::Zstd => "zstd",
            Self::Entropy => "entropy",
        }
    }
}

impl EncodedTile {
    /// Encodes the pixels of a deep map's tile. Where packing saves nothing,
    /// the tile is left plain. O(vertices).
    ///
    /// # Errors
    ///
    /// [`Error::Io`](crate::error::Error::Io) if the compressor fails.
    pub fn encode<T: Transmittance>(
        pixels: PixelListsView<'_, T>,
        codec: Codec,
        packing: Packing,
    ) -> Result<Self> {
        match codec {
            Codec::Exact => exact::encode(pixels, packing),
            Codec::Quantized => quantized::encode(pixels, packing),
        }
    }
}
