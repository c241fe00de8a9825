//! Writes deep maps.

use std::path::Path;

use dsm_core::detail::PixelListsView;
use dsm_core::{DeepMap, Transmittance};

use crate::achieved_error::AchievedError;
use crate::codec::{Codec, Packing};
use crate::columns::Columns;
use crate::crop::Crop;
use crate::error::{Error, Result};
use crate::format::encoded_tile::EncodedTile;
use crate::format::level::Level;
use crate::kind::deep::{Deep, DeepKeys};
use crate::kind::writer::KindWriter;
use crate::metadata::Metadata;
use crate::tile_id::TileId;
use crate::write_options::WriteOptions;

/// Writes a deep map tile by tile.
///
/// The file appears under its name when [`Self::finish`] has written all of
/// it to the disk; until then, and if that never happens, whatever had the
/// name stays as it was. A symbolic link stays one, and the file that it leads
/// to is replaced. A file that is replaced keeps its permissions; a new one has
/// those of any new file. Memory: 64 bytes for each tile of the map, and one
/// encoded tile.
///
/// While it is written, the file is called `.NAME.xxxxxx.partial` beside its
/// place. A process that is killed leaves it there; whoever writes the same
/// name next removes it. Files that are being written are locked (an advisory
/// lock), so that nobody removes those.
///
/// ```
/// use dsm_core::{MapInfo, PixelListsBuilder, Vertex};
/// use dsm_io::detail::{MapWriter, TileId};
/// use dsm_io::{AchievedError, Limits, MapReader, Metadata, WriteOptions};
///
/// let mut pixels = PixelListsBuilder::<f32>::new(2, 1);
/// pixels.push(Vertex::new(2.0, 1.0));
/// pixels.push(Vertex::new(2.0, 0.25));
/// pixels.finish_pixel()?;
/// pixels.finish_pixel()?;
/// let pixels = pixels.finish()?;
///
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("shadow.dsm");
/// let metadata = Metadata::new(2, 1, 1, MapInfo::default());
/// let mut writer = MapWriter::create(&path, metadata, WriteOptions::default())?;
/// writer.write_tile(TileId::new(0, 0, 0), pixels.view(), AchievedError::NONE)?;
/// writer.finish()?;
///
/// let map = MapReader::open(&path, &Limits::default())?.read_map::<f32>(0)?;
/// assert_eq!(map.pixel(0, 0).at(3.0), 0.25);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct MapWriter {
    file: KindWriter<Deep>,
    is_crop: bool,
}

impl MapWriter {
    /// Starts a map that will replace the file at `path`, if there is one.
    /// Its level 0 has the size and tolerance that the metadata state.
    ///
    /// # Errors
    ///
    /// [`Error::Metadata`] or [`Error::Setting`] if the metadata or options
    /// break a rule; [`Error::Limit`] if a reader would not accept them by
    /// default; [`Error::File`] if no file can be created there.
    pub fn create(
        path: impl AsRef<Path>,
        metadata: Metadata,
        options: WriteOptions,
    ) -> Result<Self> {
        let file = KindWriter::create(path, metadata, &DeepKeys {}, options)?;
        Ok(Self { file, is_crop: false })
    }

    /// Starts a file that holds a part of a map, whose whole the metadata
    /// describe. Tiles count from the crop's first; no other levels may be
    /// added. [`merge`](crate::merge()) puts the parts together: where each
    /// tile has the same bytes, the result is the file that would have been
    /// written as a whole.
    ///
    /// ```
    /// use dsm_core::MapInfo;
    /// use dsm_io::detail::{Crop, MapWriter};
    /// use dsm_io::{Limits, MapReader, Metadata, WriteOptions};
    ///
    /// # let folder = tempfile::tempdir()?;
    /// # let path = folder.path().join("right.dsm");
    /// let whole = Metadata::new(640, 480, 1, MapInfo::default());
    /// let right = Crop { x: 320, y: 0, width: 320, height: 480 };
    /// MapWriter::create_crop(&path, whole, right, WriteOptions::default())?.finish()?;
    ///
    /// let reader = MapReader::open(&path, &Limits::default())?;
    /// assert_eq!(reader.crop(), Some(right));
    /// assert_eq!((reader.metadata().width, reader.whole_metadata().width), (320, 640));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Self::create`], and [`Error::Setting`] if the crop does not lie in
    /// the map, or doesn't begin and end on the borders of tiles or at the
    /// map's edge.
    pub fn create_crop(
        path: impl AsRef<Path>,
        metadata: Metadata,
        crop: Crop,
        options: WriteOptions,
    ) -> Result<Self> {
        let whole = Crop { x: 0, y: 0, width: metadata.width, height: metadata.height };
        let part = Some(crop).filter(|crop| *crop != whole);
        let file = KindWriter::create_part(path, metadata, part, &DeepKeys {}, options)?;
        Ok(Self { file, is_crop: part.is_some() })
    }

    /// Adds a level, such as the next of a pyramid, and returns its index.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] if its sizes break a rule, or its view and number
    /// don't follow those of the level before, or this is a crop.
    pub fn add_level(&mut self, level: Level) -> Result<u32> {
        if self.is_crop {
            return Err(Error::setting("a part of a map has one level"));
        }
        self.file.add_level(level)
    }

    /// The metadata, of a crop the whole map's.
    #[must_use]
    pub const fn metadata(&self) -> &Metadata {
        self.file.metadata()
    }

    /// The levels added so far.
    #[must_use]
    pub fn levels(&self) -> &[Level] {
        self.file.levels()
    }

    /// How the map's tiles are encoded and packed.
    pub(crate) const fn encoding(&self) -> (Codec, Packing) {
        let options = self.file.options();
        (options.codec, options.packing)
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
        pixels: PixelListsView<'_, T>,
        error: AchievedError,
    ) -> Result<()> {
        self.file.check_tile::<T>(id, [pixels.width(), pixels.height()])?;
        let (codec, packing) = self.encoding();
        self.write_encoded(id, &EncodedTile::encode(pixels, codec, packing)?, error)
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
        self.file.write_encoded(id, tile, error)
    }

    /// Writes what is missing and puts the file in its place, safe on the
    /// disk. Returns its length in bytes.
    ///
    /// # Errors
    ///
    /// [`Error::File`] if the file cannot be written or moved into place;
    /// what had its name stays then.
    pub fn finish(self) -> Result<u64> {
        self.file.finish()
    }
}

/// Cuts a whole map into tiles and writes it as level 0 of a new file, and
/// returns the file's length in bytes. `error` is that of every tile.
///
/// ```
/// use dsm_core::{DeepMap, MapInfo, PixelListsBuilder, Vertex};
/// use dsm_io::{AchievedError, Limits, MapReader, Metadata, WriteOptions, write_map};
///
/// // One pixel that half of the light passes from depth 2 on.
/// let mut pixels = PixelListsBuilder::<f32>::new(1, 1);
/// pixels.push(Vertex::new(2.0, 1.0));
/// pixels.push(Vertex::new(2.0, 0.5));
/// pixels.finish_pixel()?;
/// let map = DeepMap::new(MapInfo::new(), pixels.finish()?);
///
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("pane.dsm");
/// let metadata = Metadata::new(1, 1, 1, MapInfo::new());
/// write_map(&path, metadata, &map, AchievedError::NONE, WriteOptions::default())?;
/// let read = MapReader::open(&path, &Limits::default())?.read_map::<f32>(0)?;
/// assert_eq!(read.pixel(0, 0).at(3.0), 0.5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// As [`MapWriter::create`], [`MapWriter::write_tile`] and
/// [`MapWriter::finish`].
pub fn write_map<T: Transmittance>(
    path: impl AsRef<Path>,
    metadata: Metadata,
    map: &DeepMap<T>,
    error: AchievedError,
    options: WriteOptions,
) -> Result<u64> {
    let pixels = map.pixels().view();
    if [metadata.width, metadata.height] != [pixels.width(), pixels.height()] {
        return Err(Error::Metadata("the map has another size".to_owned()));
    }
    let mut writer = MapWriter::create(path, metadata, options)?;
    let level = writer.levels()[0];
    let [columns, rows] = level.tiles();
    for (y, x) in (0..rows).flat_map(|y| (0..columns).map(move |x| (y, x))) {
        let Some(rect) = level.tile_rect(x, y) else { continue };
        let mut tile = Columns::default();
        for row in rect.y..rect.y + rect.height {
            for column in rect.x..rect.x + rect.width {
                tile.push(pixels.pixel(column, row))?;
            }
        }
        let tile = tile.finish::<T>(rect.width, rect.height)?;
        writer.write_tile(TileId::new(0, x, y), tile.view(), error)?;
    }
    writer.finish()
}
