//! Counts of a tile cache.

use std::sync::atomic::{AtomicU64, Ordering};

/// Hits, misses and evictions of a [`TileCache`](crate::cache::TileCache) since it
/// was made, and the bytes it holds. `hits + misses` is the number of pixels and
/// tiles that were queried; a cursor hands its hits in when it turns to the cache for another
/// tile and when it is dropped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct CacheStatistics {
    /// Queries without a load: the tile was there or is 1 everywhere.
    pub hits: u64,
    /// Queries that waited for a load, one's own or another thread's.
    pub misses: u64,
    /// Tiles that were read.
    pub loads: u64,
    /// Tiles that could not be read.
    pub failed_loads: u64,
    /// Tiles that had to make room.
    pub evictions: u64,
    /// Tiles that the cache keeps.
    pub tiles: u64,
    /// Bytes of the tiles that the cache keeps; never above the budget.
    pub bytes: u64,
    /// Tiles that the cache let go and a cursor still holds, or that are on
    /// their way from one to the other.
    pub pinned_tiles: u64,
    /// Bytes of the pinned tiles. The budget does not bound them.
    pub pinned_bytes: u64,
    /// The most bytes that tiles took at one time, pinned ones included.
    pub peak_bytes: u64,
}

/// What is counted outside of locks.
#[derive(Debug, Default)]
pub(super) struct Counters {
    /// Hits that never reached the store.
    pub(super) cursor_hits: AtomicU64,
    pub(super) misses: AtomicU64,
    pub(super) loads: AtomicU64,
    pub(super) failed_loads: AtomicU64,
    live_tiles: AtomicU64,
    live_bytes: AtomicU64,
    peak_bytes: AtomicU64,
}

impl Counters {
    pub(super) fn add(counter: &AtomicU64, count: u64) {
        counter.fetch_add(count, Ordering::Relaxed);
    }

    /// A tile came to life.
    pub(super) fn tile_made(&self, bytes: u64) {
        Self::add(&self.live_tiles, 1);
        let live = self.live_bytes.fetch_add(bytes, Ordering::Relaxed) + bytes;
        self.peak_bytes.fetch_max(live, Ordering::Relaxed);
    }

    /// Nobody holds the tile any more.
    pub(super) fn tile_dropped(&self, bytes: u64) {
        self.live_tiles.fetch_sub(1, Ordering::Relaxed);
        self.live_bytes.fetch_sub(bytes, Ordering::Relaxed);
    }

    /// The statistics of a store that keeps `tiles` of `bytes`, whose shards
    /// counted `shard_hits`.
    pub(super) fn statistics(&self, kept: Kept, shard_hits: u64) -> CacheStatistics {
        let get = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        CacheStatistics {
            hits: get(&self.cursor_hits) + shard_hits,
            misses: get(&self.misses),
            loads: get(&self.loads),
            failed_loads: get(&self.failed_loads),
            evictions: kept.evictions,
            tiles: kept.tiles,
            bytes: kept.bytes,
            pinned_tiles: get(&self.live_tiles).saturating_sub(kept.tiles),
            pinned_bytes: get(&self.live_bytes).saturating_sub(kept.bytes),
            peak_bytes: get(&self.peak_bytes),
        }
    }
}

/// What a store keeps within its budget.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Kept {
    pub(super) tiles: u64,
    pub(super) bytes: u64,
    pub(super) evictions: u64,
}

impl Kept {
    pub(super) const fn add(&mut self, bytes: u64) {
        self.tiles += 1;
        self.bytes += bytes;
    }

    pub(super) const fn remove(&mut self, bytes: u64) {
        self.tiles -= 1;
        self.bytes -= bytes;
    }
}
