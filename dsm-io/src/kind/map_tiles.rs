//! The tiles of a map that is summed up.

use crate::error::Result;
use crate::format::directory::TileDirectory;
use crate::metadata::Metadata;
use crate::tile_id::TileRect;

/// The finest level of view 0 of an open map, tile by tile: what
/// [`MapKind::summary`](crate::kind::map_kind::MapKind::summary) reads.
pub trait MapTiles {
    /// The decoded pixels of a tile.
    type Tile;

    /// The map's metadata.
    fn metadata(&self) -> &Metadata;

    /// The level's tile directory.
    ///
    /// # Errors
    ///
    /// [`Error::NoSuchLevel`](crate::error::Error::NoSuchLevel).
    fn directory(&self) -> Result<&TileDirectory>;

    /// Hands every tile to `visit`, row by row. O(vertices); holds one tile.
    ///
    /// # Errors
    ///
    /// What is wrong with a tile, and the errors of `visit`.
    fn for_each_tile(&self, visit: impl FnMut(TileRect, Self::Tile) -> Result<()>) -> Result<()>;
}
