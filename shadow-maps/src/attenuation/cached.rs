//! Attenuation maps in files, read through a tile cache.

use std::sync::{Mutex, PoisonError};

use dsm_core::Transmittance;
use dsm_io::Error;
use dsm_io::detail::{CachedMap, KindReader, LookupCursor, Result};
use dsm_trace::detail::LightFrame;

use super::source::{AttenuationSource, TexelLists};
use super::store::Attenuation;
use crate::prefilter::lists::FragmentList;

/// An attenuation map whose tiles a cache keeps. Lookups are those of the map in memory,
/// bit for bit; each thread holds the tiles that it was asked for last.
#[derive(Debug)]
pub struct CachedAttenuation<T: Transmittance> {
    map: CachedMap<T, Attenuation>,
    frame: LightFrame,
    /// Those that nobody uses now.
    idle: Mutex<Vec<AttenuationCursor<T>>>,
}

/// A cursor of one thread.
#[derive(Debug)]
pub struct AttenuationCursor<T: Transmittance>(LookupCursor<T, Attenuation>);

/// The frame of the light of a file's map.
pub(super) fn frame_of(reader: &KindReader<Attenuation>) -> dsm_core::detail::Result<LightFrame> {
    let metadata = reader.metadata();
    let camera = metadata.info.camera.unwrap_or_default();
    LightFrame::new(&camera, [metadata.width, metadata.height], 0.0)
}

impl<T: Transmittance> CachedAttenuation<T> {
    /// Opens a map for lookups. Reads no tile.
    ///
    /// # Errors
    ///
    /// [`Error::Core`] for a camera that is no perspective one.
    pub fn new(map: CachedMap<T, Attenuation>) -> Result<Self> {
        let reader = map.reader();
        let frame = reader.container().in_file(frame_of(reader).map_err(Error::from))?;
        Ok(Self { map, frame, idle: Mutex::default() })
    }
}

impl<T: Transmittance> TexelLists<T> for AttenuationCursor<T> {
    type Error = Error;

    #[inline]
    fn with_list<R>(
        &self,
        texel: [u32; 2],
        look: impl FnOnce(FragmentList<'_, T>) -> R,
    ) -> Result<R> {
        self.0.with_pixel(texel, |tile, index| {
            look(tile.map_or(FragmentList::EMPTY, |tile| tile.list(index)))
        })
    }
}

impl<T: Transmittance> AttenuationSource for CachedAttenuation<T> {
    type Value = T;
    type Error = Error;
    type Lists = AttenuationCursor<T>;

    fn frame(&self) -> &LightFrame {
        &self.frame
    }

    fn with_lists<R>(&self, ask: impl FnOnce(&AttenuationCursor<T>) -> R) -> R {
        let idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let cursor = idle.unwrap_or_else(|| AttenuationCursor(self.map.cursor()));
        let answer = ask(&cursor);
        self.idle.lock().unwrap_or_else(PoisonError::into_inner).push(cursor);
        answer
    }
}
