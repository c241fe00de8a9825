//! Cached maps whose number of channels is decided at run time.

use std::path::Path;

use dsm_core::Rgb;

use crate::cache::TileCache;
use crate::cache::map::CachedMap;
use crate::error::Result;
use crate::limits::Limits;
use crate::reader::MapReader;

/// A map of either number of channels that is read through a [`TileCache`].
#[derive(Clone, Debug)]
pub enum AnyCachedMap {
    /// One channel.
    Mono(CachedMap<f32>),
    /// Three channels.
    Rgb(CachedMap<Rgb>),
}

impl AnyCachedMap {
    /// Opens a map ([`MapReader::open`]).
    ///
    /// # Errors
    ///
    /// As [`MapReader::open`].
    pub fn open(cache: &TileCache, path: impl AsRef<Path>, limits: &Limits) -> Result<Self> {
        let reader = MapReader::open(path, limits)?;
        if reader.metadata().channels == 1 {
            cache.insert(reader).map(Self::Mono)
        } else {
            cache.insert(reader).map(Self::Rgb)
        }
    }
}
