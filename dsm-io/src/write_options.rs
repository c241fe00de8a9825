//! Options of writing maps.

use crate::codec::{Block, Codec};

/// How a map is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct WriteOptions {
    /// Width and height of a tile, in pixels. Default 64.
    pub tile_size: u32,
    /// How a tile's columns are encoded. Default exact.
    pub codec: Codec,
    /// How the encoded columns are packed. Default plain.
    pub block: Block,
}

impl Default for WriteOptions {
    fn default() -> Self {
        Self { tile_size: 64, codec: Codec::Exact, block: Block::Plain }
    }
}

impl WriteOptions {
    /// The same with tiles of `tile_size` × `tile_size` pixels.
    #[must_use]
    pub const fn with_tile_size(self, tile_size: u32) -> Self {
        Self { tile_size, ..self }
    }

    /// The same with columns encoded as `codec`.
    #[must_use]
    pub const fn with_codec(self, codec: Codec) -> Self {
        Self { codec, ..self }
    }

    /// The same with tiles packed as `block`.
    #[must_use]
    pub const fn with_block(self, block: Block) -> Self {
        Self { block, ..self }
    }
}
