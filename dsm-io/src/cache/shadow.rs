//! Shadows of a cached map, for any number of threads.

use std::sync::{Mutex, PoisonError};

use dsm_core::detail::{BiasSummary, Pyramid, ShadowLookup};
use dsm_core::{AreaLight, Facing, LevelChoice, LightVisibility, ShadedPoint, Transmittance};
use glam::DVec3;

use super::cursor::LookupCursor;
use super::map::CachedMap;
use crate::error::{Error, Result};
use crate::kind::deep::Deep;
use crate::kind::map_kind::FieldKind;

/// Cursors over the levels of a [`CachedMap`], with the tiles they hold, lent
/// to one task at a time.
#[derive(Debug)]
pub struct CursorPool<T: Transmittance, K: FieldKind = Deep> {
    map: CachedMap<T, K>,
    finest_only: bool,
    /// Those that nobody uses now.
    idle: Mutex<Vec<Pyramid<LookupCursor<T, K>>>>,
}

impl<T: Transmittance, K: FieldKind> CursorPool<T, K> {
    /// Cursors over the levels that `level` may read.
    ///
    /// # Errors
    ///
    /// As [`CachedMap::pyramid`], if that is more than level 0.
    pub fn new(map: CachedMap<T, K>, level: LevelChoice) -> Result<Self> {
        let finest_only = level == LevelChoice::FINEST;
        let pool = Self { map, finest_only, idle: Mutex::default() };
        pool.with_pyramid(|_| Ok::<_, Error>(()))?;
        Ok(pool)
    }

    /// The map.
    #[must_use]
    pub const fn map(&self) -> &CachedMap<T, K> {
        &self.map
    }

    /// Calls `ask` with cursors that no other task uses meanwhile.
    ///
    /// # Errors
    ///
    /// What `ask` says.
    pub fn with_pyramid<R, E: From<Error>>(
        &self,
        ask: impl FnOnce(&Pyramid<LookupCursor<T, K>>) -> Result<R, E>,
    ) -> Result<R, E> {
        let idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let pyramid = match idle {
            Some(pyramid) => pyramid,
            // A map whose other levels are no pyramid has a finest one still.
            None if self.finest_only => {
                Pyramid::new(vec![self.map.cursor()]).map_err(Error::from)?
            }
            None => self.map.pyramid()?,
        };
        let answer = ask(&pyramid);
        self.idle.lock().unwrap_or_else(PoisonError::into_inner).push(pyramid);
        answer
    }
}

/// The shadows of a [`CachedMap`]: filtered lookups as a shadow method.
///
/// Each call takes a cursor, with the tiles it holds, that no other thread
/// uses, and puts it back: ask for many points at once.
///
/// ```no_run
/// use dsm_core::detail::ShadowLookup;
/// use dsm_core::{AreaLight, LightVisibility};
/// use dsm_io::detail::{CachedShadow, TileCache};
/// use dsm_io::Limits;
/// use glam::DVec3;
///
/// let map = TileCache::new(256 << 20).open::<f32>("shadow.dsm", &Limits::default())?;
/// let metadata = map.reader().metadata();
/// let lookup = ShadowLookup::new(&metadata.info, [metadata.width, metadata.height])?;
/// let shadow = CachedShadow::new(map, lookup)?;
/// let light = AreaLight::point(DVec3::new(0.0, 5.0, 0.0));
/// let factor = shadow.visibility(DVec3::new(1.0, 0.5, 2.0), &light, 0)?;
/// # Ok::<(), dsm_io::Error>(())
/// ```
#[derive(Debug)]
pub struct CachedShadow<T: Transmittance, K: FieldKind = Deep> {
    cursors: CursorPool<T, K>,
    lookup: ShadowLookup,
    biases: Mutex<BiasSummary>,
}

impl<T: Transmittance, K: FieldKind> CachedShadow<T, K> {
    /// Shadows of `map`, projected and filtered by `lookup`.
    ///
    /// # Errors
    ///
    /// As [`CachedMap::pyramid`], if more than level 0 is asked.
    pub fn new(map: CachedMap<T, K>, lookup: ShadowLookup) -> Result<Self> {
        Ok(Self::of_cursors(CursorPool::new(map, lookup.level())?, lookup))
    }

    /// Shadows of the map of `cursors`, which have the levels that `lookup` reads.
    #[must_use]
    pub fn of_cursors(cursors: CursorPool<T, K>, lookup: ShadowLookup) -> Self {
        Self { cursors, lookup, biases: Mutex::default() }
    }

    /// The cursors over the map.
    #[must_use]
    pub const fn cursors(&self) -> &CursorPool<T, K> {
        &self.cursors
    }

    /// The biases of all points so far.
    #[must_use]
    pub fn biases(&self) -> BiasSummary {
        *self.biases.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<T: Transmittance, K: FieldKind> LightVisibility for CachedShadow<T, K> {
    type Value = T;
    type Error = Error;

    fn visibility(&self, receiver: DVec3, light: &AreaLight, seed: u64) -> Result<T> {
        let point = ShadedPoint { position: receiver, facing: Facing::Light, seed };
        let mut values = Vec::with_capacity(1);
        self.visibilities(&[point], light, &mut values)?;
        Ok(values.pop().unwrap_or(T::CLEAR))
    }

    fn visibilities(
        &self,
        points: &[ShadedPoint],
        _: &AreaLight,
        values: &mut Vec<T>,
    ) -> Result<()> {
        let biases =
            self.cursors.with_pyramid(|pyramid| self.lookup.lights(pyramid, points, values))?;
        self.biases.lock().unwrap_or_else(PoisonError::into_inner).merge(biases);
        Ok(())
    }
}
