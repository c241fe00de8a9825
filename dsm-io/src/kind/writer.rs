//! Writes maps of any kind.

use std::path::Path;

use dsm_core::{Tolerance, Transmittance};

use super::map_kind::MapKind;
use crate::achieved_error::AchievedError;
use crate::crop::Crop;
use crate::error::{Error, Result, check_limit};
use crate::format::encoded_tile::EncodedTile;
use crate::format::level::Level;
use crate::format::write::ContainerWriter;
use crate::limits::Limits;
use crate::map_tile::MapTile;
use crate::metadata::Metadata;
use crate::tile_id::TileId;
use crate::write_options::WriteOptions;

/// Writes a map of kind `K` tile by tile, as [`MapWriter`](crate::writer::MapWriter) a deep
/// one: the file appears under its name when [`Self::finish`] has written all of it.
#[derive(Debug)]
pub struct KindWriter<K: MapKind> {
    container: ContainerWriter,
    metadata: Metadata,
    json: Vec<u8>,
    options: WriteOptions,
    kind: std::marker::PhantomData<K>,
}

impl<K: MapKind> KindWriter<K> {
    /// Starts a map that will replace the file at `path`, if there is one. Its
    /// level 0 has the size and tolerance that the metadata state.
    ///
    /// # Errors
    ///
    /// [`Error::Metadata`] or [`Error::Setting`] if metadata, keys or options break
    /// a rule; [`Error::Limit`] if a reader would not accept them by default;
    /// [`Error::File`] if no file can be created there.
    pub fn create(
        path: impl AsRef<Path>,
        metadata: Metadata,
        keys: &K::Keys,
        options: WriteOptions,
    ) -> Result<Self> {
        let tolerance = metadata.info.tolerance.epsilon();
        let level = Level::new(metadata.width, metadata.height, options.tile_size, tolerance);
        Self::start(path.as_ref(), metadata, keys, level, options)
    }

    /// Starts a file that holds a part of a map, whose whole the metadata describe, as
    /// [`MapWriter::create_crop`](crate::writer::MapWriter::create_crop) does of a deep one; all
    /// of the map without a crop. Tiles count from the crop's first.
    ///
    /// # Errors
    ///
    /// As [`Self::create`], and [`Error::Setting`] if the kind has no crops, or the crop does
    /// not lie in the map, or doesn't begin and end on the borders of tiles or at the map's
    /// edge.
    pub fn create_part(
        path: impl AsRef<Path>,
        metadata: Metadata,
        crop: Option<Crop>,
        keys: &K::Keys,
        options: WriteOptions,
    ) -> Result<Self> {
        let Some(crop) = crop else { return Self::create(path, metadata, keys, options) };
        if !K::CROPS {
            return Err(Error::setting(format!("{} is stored whole", K::TITLE)));
        }
        let past = |_| Error::setting("a crop must begin before pixel 2³¹");
        let tolerance = metadata.info.tolerance.epsilon();
        let level = Level {
            x: crop.x.try_into().map_err(past)?,
            y: crop.y.try_into().map_err(past)?,
            ..Level::new(crop.width, crop.height, options.tile_size, tolerance)
        };
        if let Some(rule) = level.broken_rule() {
            return Err(Error::setting(rule));
        }
        let whole = [metadata.width, metadata.height];
        Crop::of_level(&level, whole).map_err(Error::setting)?;
        Self::start(path.as_ref(), metadata, keys, level, options)
    }

    /// As [`Self::create`], with a level 0 of the caller's.
    pub(crate) fn start(
        path: &Path,
        metadata: Metadata,
        keys: &K::Keys,
        level: Level,
        options: WriteOptions,
    ) -> Result<Self> {
        K::check(&metadata, keys)?;
        let json = metadata.to_json_of::<K>(keys)?;
        let limit = Limits::default().max_header_bytes;
        check_limit("bytes of metadata", json.len() as u64, limit)?;
        let mut container = ContainerWriter::create(path)?;
        container.add_level(level)?;
        Ok(Self { container, metadata, json, options, kind: std::marker::PhantomData })
    }

    /// Adds a level, such as the next of a pyramid or the first of another view,
    /// and returns its index.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] if its sizes break a rule, or its view and number
    /// don't follow those of the level before.
    pub fn add_level(&mut self, level: Level) -> Result<u32> {
        self.container.add_level(level)
    }

    /// Sets the keys, of which some are known only when all tiles are.
    ///
    /// # Errors
    ///
    /// As [`Self::create`].
    pub fn set_keys(&mut self, keys: &K::Keys) -> Result<()> {
        K::check(&self.metadata, keys)?;
        self.json = self.metadata.to_json_of::<K>(keys)?;
        let limit = Limits::default().max_header_bytes;
        check_limit("bytes of metadata", self.json.len() as u64, limit)
    }

    /// Raises the tolerance that the map and its level 0 state, before a tile is written
    /// that needs it.
    ///
    /// # Errors
    ///
    /// As [`Self::create`], for a tolerance that the kind does not have.
    pub fn raise_tolerance(&mut self, tolerance: Tolerance, keys: &K::Keys) -> Result<()> {
        self.metadata.info.tolerance = tolerance;
        self.container.set_tolerance(0, tolerance.epsilon());
        self.set_keys(keys)
    }

    /// The metadata that are written.
    #[must_use]
    pub const fn metadata(&self) -> &Metadata {
        &self.metadata
    }

    /// The levels added so far.
    #[must_use]
    pub fn levels(&self) -> &[Level] {
        self.container.levels()
    }

    /// The encoding and packing of tiles, and the size of those of level 0.
    #[must_use]
    pub const fn options(&self) -> &WriteOptions {
        &self.options
    }

    /// Encodes and writes a tile; see [`Self::write_encoded`].
    ///
    /// # Errors
    ///
    /// As [`Self::write_encoded`], and [`Error::Channels`] if `T` has another
    /// number of channels than the map, or [`Error::Tile`] if the pixels
    /// have another size than the tile.
    pub fn write_tile<T: Transmittance>(
        &mut self,
        id: TileId,
        tile: &K::Tile<T>,
        error: AchievedError,
    ) -> Result<()> {
        self.check_tile::<T>(id, tile.size())?;
        let encoded = K::encode(tile, self.options.codec, self.options.packing)?;
        self.write_encoded(id, &encoded, error)
    }

    /// Refuses pixels that are not those of a tile.
    pub(crate) fn check_tile<T: Transmittance>(&self, id: TileId, size: [u32; 2]) -> Result<()> {
        let (channels, asked) = (self.metadata.channels, T::CHANNELS as u8);
        if channels != asked {
            return Err(Error::Channels { channels, asked });
        }
        let level = self.levels().get(id.level as usize);
        let rect = level.and_then(|level| level.tile_rect(id.x, id.y));
        let rect = rect.ok_or(Error::NoSuchTile(id))?;
        if size == [rect.width, rect.height] {
            return Ok(());
        }
        let [width, height] = size;
        let rule =
            format!("it has {} × {} pixels, not {width} × {height}", rect.width, rect.height);
        Err(Error::Tile { id, rule: rule.into() })
    }

    /// Writes a tile that was encoded before, by any thread. Tiles come in
    /// any order, each at most once; one that never comes is empty. The same
    /// tiles in the same order give the same bytes.
    ///
    /// The pixels must have the tile's size and the map's channels; readers
    /// refuse the tile otherwise.
    ///
    /// # Errors
    ///
    /// [`Error::NoSuchTile`], [`Error::WrittenTwice`]; [`Error::Tile`] if
    /// `error` breaks a rule or the level's tolerance; [`Error::File`] if the
    /// file cannot be written, and then it cannot be finished.
    pub fn write_encoded(
        &mut self,
        id: TileId,
        tile: &EncodedTile,
        error: AchievedError,
    ) -> Result<()> {
        self.container.write_tile(id, tile, error)
    }

    /// Writes what is missing and puts the file in its place, safe on the
    /// disk. Returns its length in bytes.
    ///
    /// # Errors
    ///
    /// [`Error::File`] if the file cannot be written or moved into place;
    /// what had its name stays then.
    pub fn finish(self) -> Result<u64> {
        self.container.finish(&self.json)
    }
}
