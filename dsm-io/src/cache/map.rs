//! A map whose tiles a cache holds.

use std::cell::Cell;
use std::marker::PhantomData;
use std::sync::Arc;

use dsm_core::Transmittance;

use super::key::Key;
use super::load::Value;
use super::statistics::Counters;
use super::store::TileStore;
use super::tile::{CachedTile, Held};
use crate::error::{Error, Result};
use crate::kind::deep::Deep;
use crate::kind::map_kind::MapKind;
use crate::kind::reader::KindReader;
use crate::tile_id::TileId;

/// An open map, which takes its tiles with it when it is closed.
#[derive(Debug)]
struct OpenMap<K: MapKind> {
    reader: KindReader<K>,
    number: u64,
    store: Arc<TileStore>,
}

impl<K: MapKind> Drop for OpenMap<K> {
    fn drop(&mut self) {
        self.store.forget(self.number);
    }
}

/// A map of kind `K` that is read through a [`TileCache`](crate::cache::TileCache). Clones are
/// the same map; any number of threads may use it, each with a cursor of its
/// own. The last clone or cursor that is dropped closes the map, and the
/// cache lets its tiles go.
#[derive(Debug)]
pub struct CachedMap<T, K: MapKind = Deep> {
    open: Arc<OpenMap<K>>,
    channels: PhantomData<T>,
}

impl<T, K: MapKind> Clone for CachedMap<T, K> {
    fn clone(&self) -> Self {
        Self { open: Arc::clone(&self.open), channels: PhantomData }
    }
}

impl<T: Transmittance, K: MapKind> CachedMap<T, K> {
    pub(super) fn new(reader: KindReader<K>, number: u64, store: Arc<TileStore>) -> Result<Self> {
        reader.check_channels::<T>()?;
        Ok(Self { open: Arc::new(OpenMap { reader, number, store }), channels: PhantomData })
    }

    /// The map's file.
    #[must_use]
    pub fn reader(&self) -> &KindReader<K> {
        &self.open.reader
    }

    /// A tile, or `None` if it is empty, which costs nothing. The tile
    /// stays in memory while it is held, whatever the budget. O(1) if the
    /// cache holds it, else O(vertices).
    ///
    /// # Errors
    ///
    /// [`Error::NoSuchTile`], or what is wrong with the tile, in an
    /// [`Error::Shared`]. The next call tries again.
    pub fn tile(&self, id: TileId) -> Result<Held<K::Tile<T>>> {
        self.tile_after(id, &Cell::new(0))
    }

    /// As [`Self::tile`]; hands in the `hits` that a cursor had since.
    pub(super) fn tile_after(&self, id: TileId, hits: &Cell<u64>) -> Result<Held<K::Tile<T>>> {
        let OpenMap { reader, number, store } = &*self.open;
        let container = reader.container();
        let (entry, _) = container.in_file(container.entry(id))?;
        if entry.is_empty() {
            hits.update(|hits| hits + 1);
            self.hand_in(hits);
            return Ok(None);
        }
        let key = Key { map: *number, tile: id };
        let value = store.get_or_load(key, hits.take(), || {
            let tile = CachedTile::new(reader.decode_tile::<T>(id)?, &store.counters);
            let bytes = tile.bytes();
            Ok((Arc::new(tile) as Value, bytes))
        })?;
        // A map's number stands for one kind and number of channels.
        let tile = value.downcast::<CachedTile<K::Tile<T>>>().map_err(|_| Error::Channels {
            channels: reader.metadata().channels,
            asked: T::CHANNELS as u8,
        })?;
        Ok(Some(tile))
    }
}

impl<T, K: MapKind> CachedMap<T, K> {
    /// Adds a cursor's hits to the statistics.
    pub(super) fn hand_in(&self, hits: &Cell<u64>) {
        Counters::add(&self.open.store.counters.cursor_hits, hits.take());
    }
}
