//! Options of writing maps.

use crate::codec::{Codec, Packing};

/// Storage of a map: tile size, codec and packing.
///
/// ```
/// use dsm_io::{Codec, WriteOptions};
///
/// let options = WriteOptions::default().with_tile_size(32).with_codec(Codec::Quantized);
/// assert_eq!((options.tile_size, options.codec.name()), (32, "quantized"));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct WriteOptions {
    /// Width and height of a tile, in pixels. Default 64.
    pub tile_size: u32,
    /// The encoding of a tile's columns. Default exact.
    pub codec: Codec,
    /// The packing of the encoded columns. Default plain.
    pub packing: Packing,
}

impl Default for WriteOptions {
    fn default() -> Self {
        Self { tile_size: 64, codec: Codec::Exact, packing: Packing::Plain }
    }
}

impl WriteOptions {
    /// Sets the width and height of tiles in pixels.
    #[must_use]
    pub const fn with_tile_size(self, tile_size: u32) -> Self {
        Self { tile_size, ..self }
    }

    /// Sets the encoding of columns.
    #[must_use]
    pub const fn with_codec(self, codec: Codec) -> Self {
        Self { codec, ..self }
    }

    /// Sets the packing of tiles.
    #[must_use]
    pub const fn with_packing(self, packing: Packing) -> Self {
        Self { packing, ..self }
    }
}
