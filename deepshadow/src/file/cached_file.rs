//! A map's file behind a tile cache, with its number of channels decided.

use dsm_core::Rgb;
use dsm_io::detail::{CachedMap, Container, KindReader, MapKind};

use super::open_options::OpenOptions;
use crate::error::Result;

/// An open map of kind `K`, whose tiles a cache keeps.
#[derive(Debug)]
pub(crate) enum CachedFile<K: MapKind> {
    Mono(CachedMap<f32, K>),
    Rgb(CachedMap<Rgb, K>),
}

impl<K: MapKind> CachedFile<K> {
    pub(crate) fn open(container: Container, options: &OpenOptions) -> Result<Self> {
        let reader = KindReader::<K>::new(container, &options.limits)?;
        Ok(if reader.metadata().channels == 1 {
            Self::Mono(options.cache.insert(reader)?)
        } else {
            Self::Rgb(options.cache.insert(reader)?)
        })
    }

    pub(crate) fn reader(&self) -> &KindReader<K> {
        match self {
            Self::Mono(map) => map.reader(),
            Self::Rgb(map) => map.reader(),
        }
    }
}
