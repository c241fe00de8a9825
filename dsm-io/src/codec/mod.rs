//! How the pixels of a tile become bytes, and come back.
//!
//! A codec turns pixels into columns of 32-bit words; a block packs the
//! columns. Both are named in the tile's directory entry.

pub(crate) mod exact;
mod packed;
pub(crate) mod quantized;
pub(crate) mod tile_columns;
mod words;

use dsm_core::{PixelListsView, Transmittance};

use crate::Result;
use crate::format::directory::TileEntry;

/// How columns are encoded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Codec {
    /// Depths and values as they are in memory, `f32`.
    #[default]
    Exact,
    /// The small numbers that depths and values are on the grids that they were
    /// rounded to ([`dsm_core::Quantization`]). A tile whose values lie on no
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

/// How encoded columns are packed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Block {
    /// As they are, so that an exact tile can be used where it lies.
    #[default]
    Plain,
    /// Their bytes shuffled by significance in a zstd frame.
    Zstd,
}

impl Block {
    /// The block's number in the file.
    pub(crate) const fn tag(self) -> u8 {
        match self {
            Self::Plain => 0,
            Self::Zstd => 1,
        }
    }

    /// The block with this number in the file, if it is known.
    #[must_use]
    pub const fn from_tag(tag: u8) -> Option<Self> {
        match tag {
            0 => Some(Self::Plain),
            1 => Some(Self::Zstd),
            _ => None,
        }
    }

    /// The block's name, as the command line spells it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Plain => "none",
            Self::Zstd => "zstd",
        }
    }
}

/// A tile ready to be written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EncodedTile {
    /// The payload; none if the tile is empty.
    pub bytes: Vec<u8>,
    /// Length of the payload once unpacked, in bytes.
    pub raw_length: u64,
    /// Number of vertices in all pixels.
    pub vertex_count: u64,
    /// The smallest depth of all vertices.
    pub z_min: f32,
    /// The largest depth of all vertices.
    pub z_max: f32,
    /// How far depths were moved away from the light at most.
    pub depth_error: f32,
    /// The codec's number in the file.
    pub codec: u8,
    /// The block's number in the file.
    pub block: u8,
    /// Which columns are stored as differences: bit i for column i.
    pub differences: u8,
}

impl EncodedTile {
    /// Encodes the pixels of a deep map's tile. Where packing saves nothing,
    /// the tile is left plain. O(vertices).
    ///
    /// # Errors
    ///
    /// [`Error::Caller`](crate::Error::Caller) if the compressor fails.
    pub fn encode<T: Transmittance>(
        pixels: PixelListsView<'_, T>,
        codec: Codec,
        block: Block,
    ) -> Result<Self> {
        match codec {
            Codec::Exact => exact::encode(pixels, block),
            Codec::Quantized => quantized::encode(pixels, block),
        }
    }

    /// The tile that the directory says this of.
    pub(crate) const fn of_entry(entry: &TileEntry, bytes: Vec<u8>) -> Self {
        Self {
            bytes,
            raw_length: entry.raw_length,
            vertex_count: entry.vertex_count,
            z_min: entry.z_min,
            z_max: entry.z_max,
            depth_error: entry.depth_error,
            codec: entry.codec,
            block: entry.block,
            differences: entry.differences,
        }
    }

    /// The same tile of functions whose depths were moved away from the light
    /// by up to `depth_error` before.
    #[must_use]
    pub(crate) fn with_depth_error(mut self, depth_error: f32) -> Self {
        if self.vertex_count > 0 {
            self.depth_error = self.depth_error.max(depth_error);
        }
        self
    }

    /// What the directory says of the tile, wherever it will stand.
    pub(crate) fn entry(&self) -> TileEntry {
        TileEntry {
            raw_length: self.raw_length,
            vertex_count: self.vertex_count,
            z_min: self.z_min,
            z_max: self.z_max,
            depth_error: self.depth_error,
            codec: self.codec,
            block: self.block,
            differences: self.differences,
            ..TileEntry::default()
        }
    }
}
