//! Reads deep maps.

use std::path::Path;

use dsm_core::{DeepMap, PixelLists, Rgb, Transmittance};

use crate::achieved_error::AchievedError;
use crate::codec::{Block, Codec, exact, quantized};
use crate::columns::Columns;
use crate::crop::Crop;
use crate::error::{Error, Place, Result, check_limit};
use crate::format::container::Container;
use crate::format::directory::TileDirectory;
use crate::format::encoded_tile::EncodedTile;
use crate::format::level::Level;
use crate::limits::Limits;
use crate::metadata::Metadata;
use crate::source::memory::Memory;
use crate::tile::Tile;
use crate::tile_id::{TileId, TileRect};

/// An open deep map. Any number of threads may read from it.
///
/// ```no_run
/// use dsm_io::{Limits, MapReader, TileId};
///
/// let reader = MapReader::open("shadow.dsm", &Limits::default())?;
/// let tile = reader.tile::<f32>(TileId::new(0, 0, 0))?;
/// println!("{}", tile.view().pixel(0, 0).at(4.5));
/// # Ok::<(), dsm_io::Error>(())
/// ```
#[derive(Debug)]
pub struct MapReader {
    container: Container,
    metadata: Metadata,
    /// Of a crop: what it is, and what the file states.
    whole: Option<(Crop, Metadata)>,
    limits: Limits,
}

impl MapReader {
    /// Maps a file into memory; see [`Container::open`] for what that means
    /// if another process truncates the file.
    ///
    /// # Errors
    ///
    /// [`Error::File`], naming the file, with what is wrong with it.
    pub fn open(path: impl AsRef<Path>, limits: &Limits) -> Result<Self> {
        Container::open(path, limits).and_then(|container| Self::new(container, limits))
    }

    /// Reads a whole file into memory.
    ///
    /// # Errors
    ///
    /// As [`Self::open`].
    pub fn open_in_memory(path: impl AsRef<Path>, limits: &Limits) -> Result<Self> {
        Container::open_in_memory(path, limits).and_then(|container| Self::new(container, limits))
    }

    /// Opens a file that is in memory already.
    ///
    /// # Errors
    ///
    /// What is wrong with it.
    pub fn from_bytes(bytes: Vec<u8>, limits: &Limits) -> Result<Self> {
        Container::from_source(Memory::from(bytes), limits)
            .and_then(|container| Self::new(container, limits))
    }

    /// Opens the deep map that a container holds.
    ///
    /// # Errors
    ///
    /// [`Error::Kind`] if it holds another kind of map.
    pub fn new(container: Container, limits: &Limits) -> Result<Self> {
        let checked = container.metadata().and_then(Metadata::from_json).and_then(|stated| {
            let refuse = |reason| Err(Error::invalid(Place::Level(0), reason));
            let crop = match Crop::of_level(container.level(0)?, [stated.width, stated.height]) {
                Ok(crop) => crop,
                Err(reason) => return refuse(reason),
            };
            let Some(crop) = crop else { return Ok((stated, None)) };
            if container.levels().len() > 1 {
                return refuse("a part of a map has one level");
            }
            Ok((crop.metadata(&stated)?, Some((crop, stated))))
        });
        let (metadata, whole) = checked.map_err(|error| error.in_file(container.path()))?;
        Ok(Self { container, metadata, whole, limits: limits.clone() })
    }

    /// The file's sections, levels and tiles.
    #[must_use]
    pub const fn container(&self) -> &Container {
        &self.container
    }

    /// What the map says of itself. Of a crop: what it would as a map of its
    /// own, its size and its window among the whole map's.
    #[must_use]
    pub const fn metadata(&self) -> &Metadata {
        &self.metadata
    }

    /// Which part of a map this is, if it is not a whole one.
    #[must_use]
    pub fn crop(&self) -> Option<Crop> {
        self.whole.as_ref().map(|(crop, _)| *crop)
    }

    /// What the whole map says of itself, as the file states it.
    #[must_use]
    pub fn whole_metadata(&self) -> &Metadata {
        self.whole.as_ref().map_or(&self.metadata, |(_, whole)| whole)
    }

    /// The levels, finest first, view by view.
    #[must_use]
    pub fn levels(&self) -> &[Level] {
        self.container.levels()
    }

    /// The tile directory of a level.
    ///
    /// # Errors
    ///
    /// [`Error::NoSuchLevel`].
    pub fn directory(&self, level: u32) -> Result<&TileDirectory> {
        self.container.directory(level)
    }

    /// The pixels that a tile covers.
    ///
    /// # Errors
    ///
    /// [`Error::NoSuchTile`].
    pub fn tile_rect(&self, id: TileId) -> Result<TileRect> {
        self.container.entry(id).map(|(_, rect)| rect)
    }

    /// The pixels of a tile: checks its checksum and every function's
    /// invariant; decodes it, or gives a plain one where it lies. O(vertices).
    ///
    /// # Errors
    ///
    /// [`Error::Channels`] if `T` has another number of channels than the
    /// map, [`Error::NoSuchTile`], or what is wrong with the tile.
    pub fn tile<T: Transmittance>(&self, id: TileId) -> Result<Tile<'_, T>> {
        self.check_channels::<T>()?;
        self.read_tile(id).map_err(|error| error.in_file(self.container.path()))
    }

    fn read_tile<T: Transmittance>(&self, id: TileId) -> Result<Tile<'_, T>> {
        let (entry, rect) = self.container.entry(id)?;
        if entry.is_empty() {
            check_limit("pixels of a tile", rect.pixel_count(), self.limits.max_pixels)?;
            return Ok(Tile::Owned(PixelLists::clear(rect.width, rect.height)));
        }
        let place = entry.place(id);
        match Codec::from_tag(entry.codec) {
            Some(Codec::Exact) => {
                let payload = self.container.payload(id)?;
                exact::decode(payload, entry, rect, place, &self.limits)
            }
            Some(Codec::Quantized) => {
                let payload = self.container.payload(id)?;
                quantized::decode(payload, entry, rect, place, &self.limits)
            }
            None => Err(Error::Unsupported { place, what: format!("codec {}", entry.codec) }),
        }
    }

    /// A tile as it is stored, its checksum checked but its pixels not decoded,
    /// and its error: what [`MapWriter::write_encoded`] takes. O(bytes).
    ///
    /// [`MapWriter::write_encoded`]: crate::MapWriter::write_encoded
    ///
    /// # Errors
    ///
    /// [`Error::NoSuchTile`], or what is wrong with its checksum.
    pub fn encoded_tile(&self, id: TileId) -> Result<(EncodedTile, AchievedError)> {
        let read = self.container.payload(id).and_then(|bytes| {
            let (entry, _) = self.container.entry(id)?;
            Ok((EncodedTile::of_entry(entry, bytes.to_vec()), entry.error))
        });
        read.map_err(|error| error.in_file(self.container.path()))
    }

    /// How level 0's tiles are packed; `None` if all are empty. Tiles that
    /// packing didn't make smaller are plain among packed ones. O(tiles).
    ///
    /// # Errors
    ///
    /// As [`Self::directory`].
    pub(crate) fn block(&self) -> Result<Option<Block>> {
        let stored = self.directory(0)?.iter().filter(|(_, entry)| !entry.is_empty());
        // Plain is the lowest number.
        Ok(stored.map(|(_, entry)| entry.block).max().and_then(Block::from_tag))
    }

    pub(crate) fn check_channels<T: Transmittance>(&self) -> Result<()> {
        let (channels, asked) = (self.metadata.channels, T::CHANNELS as u8);
        if channels == asked { Ok(()) } else { Err(Error::Channels { channels, asked }) }
    }

    /// Reads a whole level into memory. Holds the level and one row of tiles.
    ///
    /// # Errors
    ///
    /// [`Error::Limit`] if the level has more pixels, bytes or values than a
    /// map in memory may have; else as [`Self::tile`].
    pub fn read_map<T: Transmittance>(&self, level: u32) -> Result<DeepMap<T>> {
        self.check_channels::<T>()?;
        let pixels = self.container.level(level).and_then(|found| self.assemble(level, found));
        let pixels = pixels.map_err(|error| error.in_file(self.container.path()))?;
        Ok(DeepMap::new(self.metadata.info, pixels))
    }

    fn assemble<T: Transmittance>(&self, index: u32, level: &Level) -> Result<PixelLists<T>> {
        check_limit("pixels", level.pixel_count(), self.limits.max_pixels)?;
        // A few stored bytes can be very many unpacked ones, tile after tile.
        let directory = self.container.directory(index)?;
        let lengths = directory.iter().map(|(_, entry)| entry.raw_length);
        let bytes = lengths.fold(0, u64::saturating_add);
        check_limit("bytes of a map in memory", bytes, self.limits.max_in_memory_bytes)?;
        let [columns, rows] = level.tiles();
        let mut map = Columns::default();
        for tile_y in 0..rows {
            let tiles = (0..columns)
                .map(|tile_x| self.read_tile::<T>(TileId::new(index, tile_x, tile_y)))
                .collect::<Result<Vec<_>>>()?;
            let height = tiles.first().map_or(0, |tile| tile.view().height());
            for y in 0..height {
                for tile in &tiles {
                    let pixels = tile.view();
                    for x in 0..pixels.width() {
                        map.push(pixels.pixel(x, y))?;
                    }
                }
            }
        }
        map.finish(level.width, level.height)
    }

    /// Looks for everything that can be wrong with the file: every checksum,
    /// every tile's functions, and whether what the directories, levels and
    /// metadata state of them is true. Empty if nothing is wrong. What is
    /// wrong with a file that cannot be opened is the error of that.
    /// O(vertices); holds one tile.
    #[must_use]
    pub fn verify(&self) -> Vec<Error> {
        let tolerance = self.metadata.info.tolerance.epsilon();
        self.container.verify(tolerance, |id| match self.metadata.channels {
            1 => self.read_tile::<f32>(id).map(drop),
            _ => self.read_tile::<Rgb>(id).map(drop),
        })
    }
}
