//! One of the parts that a tile store is cut into, so that threads seldom
//! want the same lock.

use std::any::Any;
use std::collections::HashMap;
use std::sync::{Arc, Weak};

use lru::LruCache;

use super::key::Key;
use super::load::{Load, Value};

#[derive(Debug)]
struct Entry {
    value: Value,
    bytes: u64,
    last_use: u64,
}

/// What a shard knows of a tile.
pub(super) enum Found {
    /// It is there.
    Kept(Value),
    /// It was let go, but somebody holds it. Its bytes.
    Pinned(Value, u64),
    /// Another thread is loading it.
    Loading(Arc<Load>),
    /// It must be loaded; whoever was told so must.
    Absent(Arc<Load>),
}

#[derive(Debug)]
pub(super) struct Shard {
    /// In the order of `last_use`.
    kept: LruCache<Key, Entry>,
    /// Tiles that were let go while somebody held them, so that nobody reads
    /// them again as long as they live.
    pinned: HashMap<Key, (Weak<dyn Any + Send + Sync>, u64)>,
    /// Length of `pinned` at which dead tiles are looked for.
    sweep_at: usize,
    loading: HashMap<Key, Arc<Load>>,
    pub(super) hits: u64,
}

impl Default for Shard {
    fn default() -> Self {
        Self {
            kept: LruCache::unbounded(),
            pinned: HashMap::new(),
            sweep_at: 64,
            loading: HashMap::new(),
            hits: 0,
        }
    }
}

impl Shard {
    pub(super) fn find(&mut self, key: Key, now: impl FnOnce() -> u64) -> Found {
        if let Some(entry) = self.kept.get_mut(&key) {
            entry.last_use = now();
            self.hits += 1;
            return Found::Kept(Arc::clone(&entry.value));
        }
        if let Some((value, bytes)) = self.pinned.get(&key)
            && let Some(value) = value.upgrade()
        {
            self.hits += 1;
            return Found::Pinned(value, *bytes);
        }
        if let Some(load) = self.loading.get(&key) {
            return Found::Loading(Arc::clone(load));
        }
        let load = Arc::new(Load::new());
        self.loading.insert(key, Arc::clone(&load));
        Found::Absent(load)
    }

    /// The load of this tile is over.
    pub(super) fn end_load(&mut self, key: Key) {
        self.loading.remove(&key);
    }

    /// Marks a tile that is kept as used; whether it is.
    pub(super) fn touch(&mut self, key: Key, now: impl FnOnce() -> u64) -> bool {
        self.kept.get_mut(&key).map(|entry| entry.last_use = now()).is_some()
    }

    /// Keeps a tile that is not kept yet.
    pub(super) fn keep(&mut self, key: Key, value: Value, bytes: u64, now: impl FnOnce() -> u64) {
        self.pinned.remove(&key);
        self.kept.put(key, Entry { value, bytes, last_use: now() });
    }

    /// Remembers a tile that is not kept, as long as somebody holds it.
    pub(super) fn pin(&mut self, key: Key, value: &Value, bytes: u64) {
        if self.pinned.len() >= self.sweep_at {
            self.pinned.retain(|_, (value, _)| value.strong_count() > 0);
            self.sweep_at = 64.max(2 * self.pinned.len());
        }
        self.pinned.insert(key, (Arc::downgrade(value), bytes));
    }

    /// When the tile was used that nobody has used for longest.
    pub(super) fn oldest_use(&self) -> Option<u64> {
        self.kept.peek_lru().map(|(_, entry)| entry.last_use)
    }

    /// Lets the tile go that nobody has used for longest.
    pub(super) fn evict(&mut self) -> Option<(Value, u64)> {
        let (key, Entry { value, bytes, .. }) = self.kept.pop_lru()?;
        if Arc::strong_count(&value) > 1 {
            self.pin(key, &value, bytes);
        }
        Some((value, bytes))
    }

    /// Lets all tiles of a map go, and tells the bytes of each.
    pub(super) fn forget(&mut self, map: u64, mut let_go: impl FnMut(u64)) {
        self.kept.retain(|key, entry| {
            let keep = key.map != map;
            if !keep {
                let_go(entry.bytes);
            }
            keep
        });
        self.pinned.retain(|key, _| key.map != map);
    }

    #[cfg(test)]
    pub(super) fn keys(&self) -> Vec<Key> {
        self.kept.iter().map(|(key, _)| *key).collect()
    }

    /// How many threads wait for the load of a tile.
    #[cfg(test)]
    pub(super) fn waiting(&self, key: Key) -> usize {
        // The list's and the loading thread's are no waiters.
        self.loading.get(&key).map_or(0, |load| Arc::strong_count(load) - 2)
    }

    #[cfg(test)]
    pub(super) fn remembered(&self) -> usize {
        self.pinned.len() + self.loading.len()
    }
}
