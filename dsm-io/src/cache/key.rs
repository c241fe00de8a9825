//! The names of tiles in a store.

use crate::tile_id::TileId;

/// A tile of one of the cache's maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Key {
    /// The map's number, which is never given to another.
    pub(super) map: u64,
    pub(super) tile: TileId,
}

impl Key {
    /// Which of `count` shards holds the tile. Neighbours are in different
    /// ones.
    pub(super) const fn shard(self, count: usize) -> usize {
        let TileId { level, x, y } = self.tile;
        let mixed = (x as u64) + 5 * (y as u64) + 7 * (level as u64);
        (mixed.wrapping_add(self.map.wrapping_mul(11)) % count as u64) as usize
    }
}
