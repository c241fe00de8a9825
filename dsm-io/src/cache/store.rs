//! Decoded tiles within a byte budget, the least recently used ones let go
//! first, over all shards.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::key::Key;
use super::load::{Load, Loaded, Value};
use super::shard::{Found, Shard};
use super::statistics::{CacheStatistics, Counters, Kept};
use crate::error::{Error, Result};

const SHARDS: usize = 16;

/// Locks `mutex`. Nothing panics while it holds one of this module's locks,
/// so what they guard is whole even if a lock was poisoned.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The tiles of all maps of a cache.
///
/// A tile that is found costs its shard's lock. Tiles are added and removed
/// under one more lock, which is taken before a shard's: whoever adds a tile
/// makes room first, so the budget holds over all shards at any time. That is
/// rare beside the reading of a tile.
#[derive(Debug)]
pub(super) struct TileStore {
    budget: u64,
    shards: [Mutex<Shard>; SHARDS],
    kept: Mutex<Kept>,
    /// Orders the uses of all shards.
    clock: AtomicU64,
    pub(super) counters: Arc<Counters>,
}

impl TileStore {
    pub(super) fn new(budget: u64) -> Self {
        Self {
            budget,
            shards: std::array::from_fn(|_| Mutex::default()),
            kept: Mutex::default(),
            clock: AtomicU64::new(0),
            counters: Arc::default(),
        }
    }

    pub(super) const fn budget(&self) -> u64 {
        self.budget
    }

    fn shard(&self, key: Key) -> MutexGuard<'_, Shard> {
        lock(&self.shards[key.shard(SHARDS)])
    }

    fn now(&self) -> u64 {
        self.clock.fetch_add(1, Ordering::Relaxed)
    }

    /// The tile of `key`, or else what `load` makes: the tile and its bytes.
    /// One thread at a time loads a tile; the others wait for what it gets. A
    /// failure is theirs as well, and then forgotten. `hits` are counted that
    /// came before this call.
    pub(super) fn get_or_load(
        &self,
        key: Key,
        mut hits: u64,
        load: impl FnOnce() -> Result<(Value, u64)>,
    ) -> Result<Value> {
        loop {
            let found = {
                let mut shard = self.shard(key);
                shard.hits += std::mem::take(&mut hits);
                shard.find(key, || self.now())
            };
            let loaded = match found {
                Found::Kept(value) => Ok(value),
                Found::Pinned(value, bytes) => {
                    self.keep(key, &value, bytes);
                    Ok(value)
                }
                Found::Loading(other) => {
                    // A load that panicked: this thread may try.
                    let Some(loaded) = other.wait() else { continue };
                    Counters::add(&self.counters.misses, 1);
                    loaded
                }
                Found::Absent(own) => {
                    Counters::add(&self.counters.misses, 1);
                    let guard = LoadGuard { store: self, key, load: own };
                    guard.run(load)
                }
            };
            return loaded.map_err(Error::Shared);
        }
    }

    /// Keeps a tile, as the one used last, and lets others go until it fits.
    /// One larger than the budget is only remembered.
    fn keep(&self, key: Key, value: &Value, bytes: u64) {
        let mut kept = lock(&self.kept);
        if self.shard(key).touch(key, || self.now()) {
            return;
        }
        if bytes > self.budget {
            self.shard(key).pin(key, value, bytes);
            return;
        }
        // Tiles are freed after the lock is.
        let mut evicted = Vec::new();
        while kept.bytes > self.budget - bytes {
            let Some((value, bytes)) = self.evict() else { break };
            kept.remove(bytes);
            kept.evictions += 1;
            evicted.push(value);
        }
        self.shard(key).keep(key, Arc::clone(value), bytes, || self.now());
        kept.add(bytes);
        drop(kept);
    }

    /// Lets the tile go that nobody has used for longest; `None` if there is
    /// none. Nobody removes tiles meanwhile. One that is used meanwhile may
    /// make another one of its shard the victim.
    fn evict(&self) -> Option<(Value, u64)> {
        let oldest = self.shards.iter().filter_map(|shard| {
            let use_of_shard = lock(shard).oldest_use()?;
            Some((use_of_shard, shard))
        });
        let (_, shard) = oldest.min_by_key(|&(last_use, _)| last_use)?;
        lock(shard).evict()
    }

    /// Lets all tiles of a map go.
    pub(super) fn forget(&self, map: u64) {
        let mut kept = lock(&self.kept);
        for shard in &self.shards {
            lock(shard).forget(map, |bytes| kept.remove(bytes));
        }
    }

    pub(super) fn statistics(&self) -> CacheStatistics {
        let kept = *lock(&self.kept);
        let hits = self.shards.iter().map(|shard| lock(shard).hits).sum();
        self.counters.statistics(kept, hits)
    }
}

/// Ends a load, however it ends.
struct LoadGuard<'a> {
    store: &'a TileStore,
    key: Key,
    load: Arc<Load>,
}

impl LoadGuard<'_> {
    fn run(self, load: impl FnOnce() -> Result<(Value, u64)>) -> Loaded {
        let counters = &self.store.counters;
        let loaded = match load() {
            Ok((value, bytes)) => {
                Counters::add(&counters.loads, 1);
                // Before the load ends, so that nobody loads the tile again.
                self.store.keep(self.key, &value, bytes);
                Ok(value)
            }
            Err(error) => {
                Counters::add(&counters.failed_loads, 1);
                Err(Arc::new(error))
            }
        };
        self.load.finish(loaded.clone());
        loaded
    }
}

impl Drop for LoadGuard<'_> {
    fn drop(&mut self) {
        self.store.shard(self.key).end_load(self.key);
        self.load.abandon();
    }
}

#[cfg(test)]
mod tests;
