//! Maps of any kind.

use std::fmt;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use dsm_core::{MapInfo, Progress};
use dsm_io::detail::{AnyDeepMap, Container, Crop, ErasedMap, Level, TileRect, check_bound};
use dsm_io::dsm_remote::is_url;
use dsm_io::{
    Error as FileError, Limits, MapReader, MapSource, MapSummary, Metadata, PixelContents,
};
use dsm_scene::TracedScene;
use glam::DVec3;

use crate::error::{Error, Result};
use crate::file::open_options::OpenOptions;
use crate::file::texel_hits::TexelHits;
use crate::file::{Near, OpenMap};
use crate::kind::Kind;
use crate::kinds::implementation;
use crate::query::method::Method;
use crate::query::settings::Query;
use crate::shadow::handle::Shadow;
use crate::values::Values;

/// A shadow map in a file, of any kind and number of channels. Clones are the same
/// map; any number of threads may use it.
///
/// The file's tiles are read when they are needed, each checked, through a cache
/// ([`OpenOptions`]). Of a file that another process writes to meanwhile, what was
/// changed is an error.
///
/// ```
/// use deepshadow::glam::DVec3;
/// use deepshadow::{Bake, Query, ShadowMap, bake};
///
/// let scene = deepshadow::scene::builtin_scene("spinning-sphere")?;
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("sphere.dsm");
/// let go_on = |_| std::ops::ControlFlow::Continue(());
/// bake(&scene, &scene.light, &Bake::new([64, 64])?, &path, go_on)?;
///
/// let map = ShadowMap::open(&path)?;
/// assert_eq!((map.kind(), map.size()), ("deep", [64, 64]));
/// assert!(map.verify().is_empty());
/// // The light itself is lit.
/// let values = map.query(&[scene.light.view.eye], &Query::new())?;
/// assert_eq!(values.rgb(0), [1.0; 3]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct ShadowMap {
    open: Arc<dyn OpenMap>,
}

impl ShadowMap {
    /// Opens a map with a tile cache of its own; [`OpenOptions::open`] shares one. A path
    /// may be an address in an object store, such as `s3://maps/key.dsm` (S3, GCS, Azure,
    /// HTTP), in a build with the feature `remote`: its tiles come when they are read
    /// ([`RemoteOptions`](crate::RemoteOptions)).
    ///
    /// # Errors
    ///
    /// [`Error::File`] with what is wrong with the file.
    pub fn open(path: impl AsRef<Path>) -> Result<Self> {
        OpenOptions::new().open(path)
    }

    fn open_with(path: &Path, options: &OpenOptions) -> Result<Self> {
        let limits = &options.limits;
        let container = match &options.remote {
            Some(remote) if is_url(path) => Container::open_remote(path, remote, limits)?,
            _ if options.is_mapped => Container::open_mapped(path, limits)?,
            _ => Container::open(path, limits)?,
        };
        let found = container.kind().map_err(|error| error.in_file(container.path()))?;
        let Some(kind) = Kind::named(&found) else {
            let error = FileError::Kind { found, wanted: "one that this program knows" };
            return Err(error.in_file(container.path()).into());
        };
        Ok(Self { open: implementation(kind).open(container, options)?.into() })
    }

    /// The part of a map that the file holds, if not a whole one.
    #[must_use]
    pub fn crop(&self) -> Option<Crop> {
        self.file().crop()
    }

    /// Refuses a part of a map whose rays go through the others.
    fn check_whole(&self) -> Result<()> {
        if self.crop().is_none() || self.kind() == Kind::DEEP.name() {
            return Ok(());
        }
        let path = self.container().path().unwrap_or(Path::new("")).to_owned();
        let reason =
            "it is a crop, whose rays go through the others: `merge` puts the map together";
        Err(Error::Query { path, reason: reason.to_owned() })
    }

    fn file(&self) -> &dyn ErasedMap {
        self.open.file()
    }

    /// What the map shows through the middle of every pixel, if its kind tells.
    pub(crate) fn texel_hits(&self) -> Option<Result<TexelHits>> {
        match self.check_whole() {
            Ok(()) => self.open.texel_hits(),
            Err(error) => Some(Err(error)),
        }
    }

    /// The name of the map's kind.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        self.file().kind()
    }

    /// Width and height of level 0 in pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        [self.metadata().width, self.metadata().height]
    }

    /// Width and height of the whole map, of a crop too.
    #[must_use]
    pub fn whole_size(&self) -> [u32; 2] {
        self.file().whole_size()
    }

    /// Numbers a value: 1 or 3.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.metadata().channels.into()
    }

    /// The camera, light, tolerance, samples, filter and windows of the map.
    #[must_use]
    pub fn info(&self) -> &MapInfo {
        &self.metadata().info
    }

    /// The header: [`Self::info`], the program that wrote it, and free attributes.
    #[must_use]
    pub fn metadata(&self) -> &Metadata {
        self.file().metadata()
    }

    /// The header's keys that only maps of this kind have.
    ///
    /// # Errors
    ///
    /// [`Error::File`] for keys that are no JSON.
    pub fn kind_metadata(&self) -> Result<serde_json::Value> {
        Ok(self.file().keys()?)
    }

    /// The levels, finest first.
    #[must_use]
    pub fn levels(&self) -> &[Level] {
        self.container().levels()
    }

    /// The file's sections, levels and tiles.
    #[must_use]
    pub fn container(&self) -> &Container {
        self.file().container()
    }

    /// The method of queries that name none.
    #[must_use]
    pub fn default_method(&self) -> Method {
        self.open.default_method()
    }

    /// The shadows of `query`, ready for any number of points. Of a map of fragments this builds the tracer: O(fragments); of other kinds it reads
    /// no more than the depths of pixels.
    ///
    /// # Errors
    ///
    /// [`Error::Query`] for what the map cannot answer,
    /// [`Error::File`] for tiles that are damaged.
    pub fn shadow(&self, query: &Query) -> Result<Shadow> {
        self.check_whole()?;
        self.open.shadow(query)
    }

    /// The shadows of `query` by short rays through a scene, which is that of the map's
    /// light, and lookups in this map of kind `prefiltered` beyond.
    ///
    /// # Errors
    ///
    /// [`Error::Query`] for maps of other kinds, else as [`Self::shadow`].
    pub fn hybrid_shadow(&self, scene: Arc<TracedScene>, query: &Query) -> Result<Shadow> {
        self.hybrid(query, &Near::Scene(scene))
    }

    /// The same with short rays through a map of kind `fragments`. O(fragments).
    ///
    /// # Errors
    ///
    /// [`Error::Query`] for maps of other kinds or numbers of channels, else as
    /// [`Self::shadow`].
    pub fn hybrid_shadow_of_maps(&self, near: &Self, query: &Query) -> Result<Shadow> {
        near.check_whole()?;
        self.hybrid(query, &Near::Map(&*near.open))
    }

    fn hybrid(&self, query: &Query, near: &Near<'_>) -> Result<Shadow> {
        self.open.hybrid(query, near).unwrap_or_else(|| {
            let path = self.container().path().unwrap_or(Path::new("")).to_owned();
            let kind = self.kind();
            let reason = format!("--method hybrid is for maps of kind prefiltered, not {kind}");
            Err(Error::Query { path, reason })
        })
    }

    /// The shadow factors of points of the world: [`Self::shadow`], queried once.
    ///
    /// # Errors
    ///
    /// As [`Self::shadow`] and [`Shadow::query`].
    pub fn query(&self, points: &[DVec3], query: &Query) -> Result<Values> {
        self.shadow(query)?.query(points)
    }

    /// Everything that is wrong with the file: checksums, rules of the format and
    /// of the kind, stated bounds. Empty if it is sound. O(vertices); holds one
    /// tile.
    #[must_use]
    pub fn verify(&self) -> Vec<FileError> {
        self.file().verify()
    }

    /// Compares every visibility function of the finest level with those of
    /// `source`, the map or image that it was made of, within the bound that the
    /// map states. `watch` is told of rows.
    ///
    /// # Errors
    ///
    /// [`Error::Query`] for kinds without a bound, [`Error::File`] with the worst
    /// pixel if the bound is broken, or with what is wrong with the source.
    pub fn check_against(
        &self,
        source: &mut MapSource,
        watch: impl FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<()> {
        let path = self.container().path().unwrap_or(Path::new(""));
        if self.kind() != Kind::DEEP.name() {
            let reason = format!("a map of kind {} has no source to be held to", self.kind());
            return Err(Error::Query { path: path.to_owned(), reason });
        }
        let reader = MapReader::open(path, &Limits::default())?;
        check_bound(reader, source, watch)?;
        Ok(())
    }

    /// Counts of what the tiles hold together. O(vertices); holds one tile.
    ///
    /// # Errors
    ///
    /// [`Error::File`] for a damaged tile.
    pub fn summary(&self) -> Result<MapSummary> {
        Ok(self.file().summary()?)
    }

    /// The numbers that are stored of a pixel of a level. Reads one tile.
    ///
    /// # Errors
    ///
    /// [`Error::File`] for a level or a pixel that there is
    /// not, or a damaged tile.
    pub fn contents(&self, level: u32, pixel: [u32; 2]) -> Result<PixelContents> {
        Ok(self.file().contents(level, pixel)?)
    }

    /// The same of each pixel of a rectangle, row by row. Each tile is read once; a row of
    /// tiles is held.
    ///
    /// # Errors
    ///
    /// As [`Self::contents`], and for more pixels than memory may hold.
    pub fn contents_of(
        &self,
        level: u32,
        pixels: TileRect,
        mut visit: impl FnMut(PixelContents),
    ) -> Result<()> {
        Ok(self.file().contents_of(level, pixels, &mut |contents| {
            visit(contents);
            Ok(())
        })?)
    }

    /// The visibility functions of a rectangle of a level; `None` for kinds
    /// without such.
    ///
    /// # Errors
    ///
    /// As [`Self::contents`], and for more pixels than memory may hold.
    pub fn functions(&self, level: u32, pixels: TileRect) -> Result<Option<AnyDeepMap>> {
        Ok(self.file().functions(level, pixels)?)
    }
}

impl OpenOptions {
    /// Opens a map.
    ///
    /// # Errors
    ///
    /// As [`ShadowMap::open`].
    pub fn open(&self, path: impl AsRef<Path>) -> Result<ShadowMap> {
        ShadowMap::open_with(path.as_ref(), self)
    }
}

impl fmt::Debug for ShadowMap {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_tuple("ShadowMap").field(&self.file()).finish()
    }
}
