//! Prefiltered maps in files, read through a tile cache.

use std::sync::{Mutex, PoisonError};

use dsm_core::Transmittance;
use dsm_io::Error;
use dsm_io::detail::{CachedMap, KindReader, LookupCursor, Result};
use dsm_trace::detail::LightFrame;

use super::lists::FragmentLists;
use super::lookup::{LevelLists, Levels, nearest_of};
use super::map::PrefilteredMap;
use super::source::PrefilteredSource;
use super::store::Prefiltered;
use super::sums::ListView;

/// A prefiltered map whose tiles a cache keeps. Lookups are those of the map in memory,
/// bit for bit; each thread holds the tiles that it was asked for last.
#[derive(Debug)]
pub struct CachedPrefiltered<T: Transmittance> {
    map: CachedMap<T, Prefiltered>,
    frame: LightFrame,
    known: Levels,
    /// Those that nobody uses now.
    idle: Mutex<Vec<CachedLists<T>>>,
}

/// A cursor a level.
#[derive(Debug)]
pub struct CachedLists<T: Transmittance> {
    cursors: Vec<LookupCursor<T, Prefiltered>>,
}

/// The frame of the light of a file's map.
fn frame_of(reader: &KindReader<Prefiltered>) -> dsm_core::detail::Result<LightFrame> {
    let metadata = reader.metadata();
    let camera = metadata.info.camera.unwrap_or_default();
    let light_depth = reader.keys().layering.light_depth.into();
    LightFrame::new(&camera, [metadata.width, metadata.height], light_depth)
}

impl<T: Transmittance> CachedPrefiltered<T> {
    /// Opens a map for lookups. Reads the directories alone: O(tiles).
    ///
    /// # Errors
    ///
    /// [`Error::Metadata`] for levels that do not fit the map, or a camera that is no
    /// perspective one.
    pub fn new(map: CachedMap<T, Prefiltered>) -> Result<Self> {
        let reader = map.reader();
        let known = known(reader);
        let frame = frame_of(reader).map_err(Error::from);
        let (frame, known) = reader.container().in_file(frame.and_then(|it| Ok((it, known?))))?;
        Ok(Self { map, frame, known, idle: Mutex::default() })
    }

    fn lists(&self) -> CachedLists<T> {
        // The levels are there: they were looked at.
        let levels = 0..self.known.geometry.len() as u32;
        let cursors = levels.filter_map(|level| self.map.level_cursor(level).ok()).collect();
        CachedLists { cursors }
    }
}

/// What the directories tell of the levels.
fn known(reader: &KindReader<Prefiltered>) -> Result<Levels> {
    let geometry = reader.keys().filtering.geometry(reader.levels());
    let geometry = geometry.map_err(|rule| Error::Metadata(rule.to_owned()))?;
    let nearest = (0..geometry.len() as u32).map(|level| {
        let tiles = reader.directory(level)?.iter().map(|(_, tile)| tile);
        let occupied = tiles.filter(|tile| !tile.is_empty());
        let depth = occupied.map(|tile| tile.z_min).reduce(f32::min);
        Ok(depth.map_or(0.0, nearest_of))
    });
    let nearest: Result<Vec<f64>> = nearest.collect();
    Ok(Levels::new(geometry, nearest?))
}

impl<T: Transmittance> LevelLists<T> for CachedLists<T> {
    type Error = Error;

    #[inline]
    fn with_list<R>(
        &self,
        level: usize,
        texel: [u32; 2],
        look: impl FnOnce(ListView<'_, T>) -> R,
    ) -> Result<R> {
        let zero = [[T::BLOCKED; 2]];
        self.cursors[level].with_pixel(texel, |tile, index| match tile {
            Some(tile) => look(tile.view(index)),
            None => look(ListView::empty(&zero)),
        })
    }
}

impl<T: Transmittance> PrefilteredSource for CachedPrefiltered<T> {
    type Value = T;
    type Error = Error;
    type Lists = CachedLists<T>;

    fn frame(&self) -> &LightFrame {
        &self.frame
    }

    fn known(&self) -> &Levels {
        &self.known
    }

    fn with_lists<R>(&self, ask: impl FnOnce(&CachedLists<T>) -> R) -> R {
        let idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let lists = idle.unwrap_or_else(|| self.lists());
        let answer = ask(&lists);
        self.idle.lock().unwrap_or_else(PoisonError::into_inner).push(lists);
        answer
    }
}

impl<T: Transmittance> PrefilteredMap<T> {
    /// Reads a whole map, all levels, row by row of tiles. O(fragments).
    ///
    /// # Errors
    ///
    /// [`Error::Channels`] for a map of another number of channels, [`Error::Limit`] for
    /// one that is too large, or what is wrong with a tile.
    pub fn read(reader: &KindReader<Prefiltered>) -> Result<Self> {
        let geometry = reader.keys().filtering.geometry(reader.levels());
        let geometry = geometry.map_err(|rule| Error::Metadata(rule.to_owned()));
        let geometry = reader.container().in_file(geometry)?;
        let mut levels = Vec::new();
        for (index, level) in (0..).zip(&geometry) {
            reader.check_in_memory(index)?;
            let mut lists = FragmentLists::new(level.size);
            reader.for_each_pixel::<T>(index, |tile, pixel| {
                let list = tile.lists().list(pixel);
                let fragments = list.w.iter().zip(list.opacities);
                fragments.for_each(|(&w, &opacity)| lists.push(w, opacity));
                Ok(lists.finish_texel()?)
            })?;
            levels.push(lists);
        }
        let frame = reader.container().in_file(frame_of(reader).map_err(Error::from))?;
        Ok(Self::of_levels(frame, levels, geometry))
    }
}
