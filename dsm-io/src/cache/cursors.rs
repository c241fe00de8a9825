//! The cursors of cached maps.

use dsm_core::Transmittance;
use dsm_core::detail::Pyramid;

use super::cursor::LookupCursor;
use super::map::CachedMap;
use crate::error::{Error, Result};
use crate::kind::map_kind::{FieldKind, MapKind};

impl<T: Transmittance, K: MapKind> CachedMap<T, K> {
    /// Looks up level 0, the finest.
    #[must_use]
    pub fn cursor(&self) -> LookupCursor<T, K> {
        // A file without levels can't be opened.
        LookupCursor::new(self.clone(), 0, &self.reader().levels()[0])
    }

    /// Looks up the level with this index.
    ///
    /// # Errors
    ///
    /// [`Error::NoSuchLevel`].
    pub fn level_cursor(&self, level: u32) -> Result<LookupCursor<T, K>> {
        let found = self.reader().container().level(level)?;
        Ok(LookupCursor::new(self.clone(), level, found))
    }
}

impl<T: Transmittance, K: FieldKind> CachedMap<T, K> {
    /// Looks up all levels of view 0, and between them.
    ///
    /// ```no_run
    /// use dsm_core::{Filter, FilterShape, Footprint, LevelChoice, Receiver};
    /// use dsm_io::detail::TileCache;
    /// use dsm_io::Limits;
    ///
    /// let map = TileCache::new(256 << 20).open::<f32>("shadow.dsm", &Limits::default())?;
    /// let pyramid = map.pyramid()?;
    /// let footprint = Footprint::Isotropic(Filter::new(FilterShape::Tent, 48.0)?);
    /// let receiver = Receiver::new([10.5, 7.25], 4.0);
    /// let light = pyramid.lookup(&receiver, &footprint, LevelChoice::Auto)?;
    /// # Ok::<(), dsm_io::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`dsm_core::Error::Level`] if the levels are no pyramid.
    pub fn pyramid(&self) -> Result<Pyramid<LookupCursor<T, K>>> {
        self.view_pyramid(0)
    }

    /// Looks up all levels of a view, and between them.
    ///
    /// # Errors
    ///
    /// [`dsm_core::Error::Level`] if the levels are no pyramid, or there is no such
    /// view.
    pub fn view_pyramid(&self, view: u32) -> Result<Pyramid<LookupCursor<T, K>>> {
        let container = self.reader().container();
        let levels = container.view(view);
        let cursors = levels.map(|(index, level)| LookupCursor::new(self.clone(), index, level));
        container.in_file(Pyramid::new(cursors.collect()).map_err(Error::from))
    }
}
