//! Keeps the tiles of many maps at hand, within a byte budget.
//!
//! A lookup goes through three places, each slower than the one before:
//!
//! 1. the slots of its thread's [`LookupCursor`](cursor::LookupCursor): no lock, nothing shared is
//!    written;
//! 2. the shards of the cache's store, each an LRU list under a lock, and
//!    beside it the tiles that were let go but that some cursor still holds;
//! 3. the file: one thread loads a tile, whoever else wants it waits.
//!
//! A tile is a copy even where its file has it as it is used: what the budget
//! counts is then what is held, and a hit depends on no page of a file.

pub(crate) mod cursor;
mod cursors;
mod key;
mod load;
pub(crate) mod map;
mod rows_ahead;
pub(crate) mod shadow;
mod shard;
mod slot;
pub(crate) mod statistics;
mod store;
pub(crate) mod tile;
mod tile_division;

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use dsm_core::Transmittance;

use self::map::CachedMap;
use self::statistics::CacheStatistics;
use crate::error::Result;
use crate::kind::map_kind::MapKind;
use crate::kind::reader::KindReader;
use crate::limits::Limits;
use crate::reader::MapReader;
use store::TileStore;

/// The tiles of any number of maps of any kinds, within one byte budget; the least recently
/// used make room. Clones are the same cache.
///
/// The budget bounds the tiles that the cache keeps, at any time
/// ([`CacheStatistics::bytes`]). On top come tiles that are being loaded, one
/// a thread, and those that a [`LookupCursor`](cursor::LookupCursor) or a caller holds and the cache
/// had to let go. A tile of more than the budget is never kept, but works.
/// A cursor's hits do not tell the cache that a tile is in use. One that it
/// lets go for that reason is still found, without a load, as long as any
/// cursor holds it.
///
/// ```no_run
/// use dsm_core::VisibilityField;
/// use dsm_io::detail::TileCache;
/// use dsm_io::Limits;
///
/// let cache = TileCache::new(1 << 30);
/// let key = cache.open::<f32>("key.dsm", &Limits::default())?;
/// let rim = cache.open::<f32>("rim.dsm", &Limits::default())?;
/// let light = key.cursor().evaluate([3, 4], 7.5)? * rim.cursor().evaluate([3, 4], 7.5)?;
/// println!("{light} {:?}", cache.statistics());
/// # Ok::<(), dsm_io::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct TileCache {
    store: Arc<TileStore>,
    next_map: Arc<AtomicU64>,
}

impl TileCache {
    /// A cache that keeps at most `budget` bytes of tiles.
    #[must_use]
    pub fn new(budget: u64) -> Self {
        Self { store: Arc::new(TileStore::new(budget)), next_map: Arc::default() }
    }

    /// The most bytes of tiles that the cache keeps.
    #[must_use]
    pub fn budget(&self) -> u64 {
        self.store.budget()
    }

    /// Opens a deep map ([`MapReader::open`]). Opening a file twice makes two maps: it
    /// may have been replaced meanwhile.
    ///
    /// # Errors
    ///
    /// As [`MapReader::open`] and [`Self::insert`].
    pub fn open<T: Transmittance>(
        &self,
        path: impl AsRef<Path>,
        limits: &Limits,
    ) -> Result<CachedMap<T>> {
        self.insert(MapReader::open(path, limits)?)
    }

    /// Takes an open map of any kind.
    ///
    /// # Errors
    ///
    /// [`Error::Channels`](crate::error::Error::Channels) if `T` has another number
    /// of channels than the map.
    pub fn insert<T: Transmittance, K: MapKind>(
        &self,
        reader: KindReader<K>,
    ) -> Result<CachedMap<T, K>> {
        let number = self.next_map.fetch_add(1, Ordering::Relaxed);
        CachedMap::new(reader, number, Arc::clone(&self.store))
    }

    /// The counts of hits, misses and bytes. Exact while no other thread uses it.
    #[must_use]
    pub fn statistics(&self) -> CacheStatistics {
        self.store.statistics()
    }
}
