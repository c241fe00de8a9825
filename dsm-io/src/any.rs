//! The one place where the number of channels is decided at run time.

use std::path::Path;

use dsm_core::{DeepMap, MapInfo, Rgb};

use crate::cache::TileCache;
use crate::cache::map::CachedMap;
use crate::error::Result;
use crate::limits::Limits;
use crate::reader::MapReader;

/// A deep map of either number of channels.
#[derive(Clone, Debug, PartialEq)]
pub enum AnyDeepMap {
    /// One channel.
    Mono(DeepMap<f32>),
    /// Three channels.
    Rgb(DeepMap<Rgb>),
}

impl AnyDeepMap {
    /// Reads a level of a map.
    ///
    /// # Errors
    ///
    /// As [`MapReader::read_map`].
    pub fn read(reader: &MapReader, level: u32) -> Result<Self> {
        if reader.metadata().channels == 1 {
            reader.read_map(level).map(Self::Mono)
        } else {
            reader.read_map(level).map(Self::Rgb)
        }
    }

    /// Number of channels: 1 or 3.
    #[must_use]
    pub const fn channels(&self) -> u8 {
        match self {
            Self::Mono(_) => 1,
            Self::Rgb(_) => 3,
        }
    }

    /// What the map says of itself.
    #[must_use]
    pub const fn info(&self) -> &MapInfo {
        match self {
            Self::Mono(map) => map.info(),
            Self::Rgb(map) => map.info(),
        }
    }
}

impl From<DeepMap<f32>> for AnyDeepMap {
    fn from(map: DeepMap<f32>) -> Self {
        Self::Mono(map)
    }
}

impl From<DeepMap<Rgb>> for AnyDeepMap {
    fn from(map: DeepMap<Rgb>) -> Self {
        Self::Rgb(map)
    }
}

/// A map of either number of channels that is read through a [`TileCache`].
#[derive(Clone, Debug)]
pub enum AnyCachedMap {
    /// One channel.
    Mono(CachedMap<f32>),
    /// Three channels.
    Rgb(CachedMap<Rgb>),
}

impl AnyCachedMap {
    /// Opens a map, mapped into memory ([`MapReader::open`]).
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
