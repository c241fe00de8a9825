//! Reads maps of any kind.

use std::marker::PhantomData;
use std::path::Path;

use dsm_core::{DeepMap, Rgb, Transmittance};

use super::map_kind::MapKind;
use super::map_tiles::MapTiles;
use super::pixel_contents::PixelContents;
use super::summary::MapSummary;
use crate::achieved_error::AchievedError;
use crate::codec::stored_tile::StoredTile;
use crate::columns::Columns;
use crate::crop::Crop;
use crate::error::{Error, Place, Result, check_limit};
use crate::format::container::Container;
use crate::format::directory::{TileDirectory, TileEntry};
use crate::format::encoded_tile::EncodedTile;
use crate::format::level::Level;
use crate::limits::Limits;
use crate::metadata::Metadata;
use crate::row_order::RowOrder;
use crate::source::memory::Memory;
use crate::tile_id::{TileId, TileRect};

/// An open map of kind `K`. Any number of threads may read from it.
///
/// Deep maps have a name of their own for it, [`MapReader`](crate::reader::MapReader).
#[derive(Debug)]
pub struct KindReader<K: MapKind> {
    pub(crate) container: Container,
    metadata: Metadata,
    keys: K::Keys,
    /// Of a crop: what it is, and what the file states.
    whole: Option<(Crop, Metadata)>,
    pub(crate) limits: Limits,
}

impl<K: MapKind> KindReader<K> {
    /// Opens a file, whose tiles are read as they are asked for.
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

    /// Opens the map that a container holds.
    ///
    /// # Errors
    ///
    /// [`Error::Kind`] if it holds another kind of map.
    pub fn new(container: Container, limits: &Limits) -> Result<Self> {
        let (stated, keys, crop) = container.in_file(Self::check(&container))?;
        let (metadata, whole) = match crop {
            None => (stated, None),
            Some(crop) => (container.in_file(crop.metadata(&stated))?, Some((crop, stated))),
        };
        Ok(Self { container, metadata, keys, whole, limits: limits.clone() })
    }

    fn check(container: &Container) -> Result<(Metadata, K::Keys, Option<Crop>)> {
        let json = container.metadata();
        Metadata::check_kind::<K>(json)?;
        let stated = Metadata::from_json_of_any_kind(json)?;
        let keys: K::Keys = serde_json::from_slice(json).map_err(Error::Json)?;
        Metadata::check_version::<K>(json, &keys)?;
        K::check(&stated, &keys)?;
        K::check_levels(container.levels(), &keys)?;
        if !K::has_errors(&keys) {
            check_exact(container)?;
        }
        let refuse = |reason: &str| Err(Error::invalid(Place::Level(0), reason.to_owned()));
        let crop = match Crop::of_level(container.level(0)?, [stated.width, stated.height]) {
            Ok(crop) => crop,
            Err(reason) => return refuse(reason),
        };
        match crop {
            Some(_) if !K::CROPS => refuse(&format!("{} is stored whole", K::TITLE)),
            Some(_) if !has_same_pixels(container.levels()) => {
                refuse("a part of a map has one level a view, all of the same pixels")
            }
            crop => Ok((stated, keys, crop)),
        }
    }

    /// The file's sections, levels and tiles.
    #[must_use]
    pub const fn container(&self) -> &Container {
        &self.container
    }

    /// The map's metadata. Of a crop: those of a map of its own, with its size and
    /// its window among the whole map's.
    #[must_use]
    pub const fn metadata(&self) -> &Metadata {
        &self.metadata
    }

    /// The metadata keys that only maps of this kind have.
    #[must_use]
    pub const fn keys(&self) -> &K::Keys {
        &self.keys
    }

    /// The part of a map that the file holds, if not a whole one.
    #[must_use]
    pub fn crop(&self) -> Option<Crop> {
        self.whole.as_ref().map(|(crop, _)| *crop)
    }

    /// The whole map's metadata, as the file states them.
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

    /// The pixels of a tile, in memory of their own: checks its checksum and all
    /// rules of the kind. O(vertices).
    ///
    /// # Errors
    ///
    /// [`Error::Channels`] if `T` has another number of channels than the
    /// map, [`Error::NoSuchTile`], or what is wrong with the tile.
    pub fn decode_tile<T: Transmittance>(&self, id: TileId) -> Result<K::Tile<T>> {
        self.check_channels::<T>()?;
        self.container.in_file(self.decode(id))
    }

    fn decode<T: Transmittance>(&self, id: TileId) -> Result<K::Tile<T>> {
        match StoredTile::read(&self.container, id, &self.limits)? {
            (Some(stored), _) => K::decode(stored, &self.keys),
            (None, rect) => K::empty([rect.width, rect.height], &self.keys),
        }
    }

    /// A tile as it is stored, its checksum checked but its pixels not decoded,
    /// and its error: what [`MapWriter::write_encoded`] takes. O(bytes).
    ///
    /// [`MapWriter::write_encoded`]: crate::writer::MapWriter::write_encoded
    ///
    /// # Errors
    ///
    /// [`Error::NoSuchTile`], or what is wrong with its checksum.
    pub fn encoded_tile(&self, id: TileId) -> Result<(EncodedTile, AchievedError)> {
        self.container.in_file(self.container.payload(id).and_then(|bytes| {
            let (entry, _) = self.container.entry(id)?;
            Ok((EncodedTile::of_entry(entry, bytes.into_owned()), entry.error))
        }))
    }

    /// Refuses a `T` with another number of channels than the map.
    ///
    /// # Errors
    ///
    /// [`Error::Channels`].
    pub fn check_channels<T: Transmittance>(&self) -> Result<()> {
        let (channels, asked) = (self.metadata.channels, T::CHANNELS as u8);
        if channels == asked { Ok(()) } else { Err(Error::Channels { channels, asked }) }
    }

    /// Hands every tile of a level to `visit`, row by row. Holds one tile.
    ///
    /// # Errors
    ///
    /// Those of [`Self::decode_tile`] and of `visit`; [`Error::NoSuchLevel`].
    pub fn for_each_tile<T: Transmittance>(
        &self,
        level: u32,
        mut visit: impl FnMut(TileRect, K::Tile<T>) -> Result<()>,
    ) -> Result<()> {
        self.check_channels::<T>()?;
        let mut visit_all = || {
            for (id, _) in self.directory(level)?.iter() {
                visit(self.tile_rect(id)?, self.decode(id)?)?;
            }
            Ok(())
        };
        self.container.in_file(visit_all())
    }

    /// Hands the pixels of a level to `visit`, in the order of the level: each with
    /// its tile and its row-major index in that. Holds one row of tiles.
    ///
    /// # Errors
    ///
    /// As [`Self::for_each_tile`].
    pub fn for_each_pixel<T: Transmittance>(
        &self,
        level: u32,
        mut visit: impl FnMut(&K::Tile<T>, usize) -> Result<()>,
    ) -> Result<()> {
        let columns = self.container.level(level)?.tiles()[0] as usize;
        let mut rows = RowOrder::new(columns);
        self.for_each_tile(level, |_, tile: K::Tile<T>| rows.push(tile, &mut visit))
    }

    /// Refuses a level that is larger than what may be read into memory at once.
    ///
    /// # Errors
    ///
    /// [`Error::Limit`] or [`Error::NoSuchLevel`].
    pub fn check_in_memory(&self, level: u32) -> Result<()> {
        let check = || {
            let pixels = self.container.level(level)?.pixel_count();
            check_limit("pixels", pixels, self.limits.max_pixels)?;
            // A few stored bytes can be very many unpacked ones, tile after tile.
            let lengths = self.container.directory(level)?.iter().map(|(_, tile)| tile.raw_length);
            let bytes = lengths.fold(0, u64::saturating_add);
            check_limit("bytes of a map in memory", bytes, self.limits.max_in_memory_bytes)
        };
        self.container.in_file(check())
    }

    /// The stored numbers of a pixel. Reads one tile.
    ///
    /// # Errors
    ///
    /// [`Error::NoSuchLevel`], [`Error::NoSuchPixel`] for one outside the level, or
    /// as [`Self::decode_tile`].
    pub fn contents<T: Transmittance>(
        &self,
        level: u32,
        [x, y]: [u32; 2],
    ) -> Result<PixelContents> {
        let found = self.container.level(level)?;
        let Some(id) = found.tile_of(level, [x, y]) else {
            return Err(Error::NoSuchPixel([x, y]));
        };
        let (rect, tile) = (self.tile_rect(id)?, self.decode_tile::<T>(id)?);
        let pixel = (y - rect.y) as usize * rect.width as usize + (x - rect.x) as usize;
        Ok(K::contents(&tile, pixel))
    }

    /// The visibility functions of a rectangle of a level, as a map of its own.
    /// Reads the tiles that it touches.
    ///
    /// # Errors
    ///
    /// [`Error::Kind`] for a kind without such; [`Error::Limit`] for more than a map
    /// in memory may have; else as [`Self::contents`].
    pub fn functions<T: Transmittance>(&self, level: u32, rect: TileRect) -> Result<DeepMap<T>> {
        self.check_channels::<T>()?;
        let pixels = self.gather(level, rect);
        Ok(DeepMap::new(self.metadata.info, self.container.in_file(pixels)?))
    }

    fn gather<T: Transmittance>(
        &self,
        index: u32,
        rect: TileRect,
    ) -> Result<dsm_core::detail::PixelLists<T>> {
        let mut map = Columns::default();
        self.visit_rect::<T>(index, rect, |tile, pixel| {
            let function = K::function(tile, pixel).ok_or_else(|| Error::Kind {
                found: K::NAME.to_owned(),
                wanted: "one with visibility functions",
            })?;
            map.push(function)
        })?;
        map.finish(rect.width, rect.height)
    }

    /// The stored numbers of the pixels of a rectangle of a level, row by row. Holds one row
    /// of tiles.
    ///
    /// # Errors
    ///
    /// As [`Self::functions`], of any kind, and those of `visit`.
    pub fn contents_of<T: Transmittance>(
        &self,
        level: u32,
        rect: TileRect,
        mut visit: impl FnMut(PixelContents) -> Result<()>,
    ) -> Result<()> {
        self.check_channels::<T>()?;
        let visited =
            self.visit_rect::<T>(level, rect, |tile, pixel| visit(K::contents(tile, pixel)));
        self.container.in_file(visited)
    }

    /// Hands the pixels of a rectangle to `visit`, each with its tile and its index in that.
    fn visit_rect<T: Transmittance>(
        &self,
        index: u32,
        rect: TileRect,
        mut visit: impl FnMut(&K::Tile<T>, usize) -> Result<()>,
    ) -> Result<()> {
        let level = self.container.level(index)?;
        let ends = [rect.x.checked_add(rect.width), rect.y.checked_add(rect.height)];
        let [Some(right), Some(bottom)] = ends else {
            return Err(Error::NoSuchPixel([rect.x, rect.y]));
        };
        if rect.pixel_count() == 0 || right > level.width || bottom > level.height {
            return Err(Error::NoSuchPixel([right, bottom].map(|end| end.saturating_sub(1))));
        }
        check_limit("pixels", rect.pixel_count(), self.limits.max_pixels)?;
        let mut row = Vec::new();
        let columns = rect.x / level.tile_width..=(right - 1) / level.tile_width;
        for tile_y in rect.y / level.tile_height..=(bottom - 1) / level.tile_height {
            row.clear();
            for tile_x in columns.clone() {
                let id = TileId::new(index, tile_x, tile_y);
                row.push((self.tile_rect(id)?, self.decode::<T>(id)?));
            }
            let top = tile_y * level.tile_height;
            for y in rect.y.max(top)..bottom.min(top.saturating_add(level.tile_height)) {
                for (of, tile) in &row {
                    for x in rect.x.max(of.x)..right.min(of.x + of.width) {
                        let pixel = (y - of.y) as usize * of.width as usize + (x - of.x) as usize;
                        visit(tile, pixel)?;
                    }
                }
            }
        }
        Ok(())
    }

    /// Counts of the contents of all tiles of the finest level. O(vertices); holds one
    /// tile.
    ///
    /// # Errors
    ///
    /// What is wrong with a tile.
    pub fn summary(&self) -> Result<MapSummary> {
        match self.metadata.channels {
            1 => K::summary(&FinestTiles::<K, f32>::new(self)),
            _ => K::summary(&FinestTiles::<K, Rgb>::new(self)),
        }
    }

    /// Looks for everything that can be wrong with the file: every checksum,
    /// every tile's rules, and whether what the directories, levels and
    /// metadata state of them is true. Empty if nothing is wrong. What is
    /// wrong with a file that cannot be opened is the error of that.
    /// O(vertices); holds one tile.
    #[must_use]
    pub fn verify(&self) -> Vec<Error> {
        let tolerance = self.metadata.info.tolerance.epsilon();
        self.container.verify(tolerance, |id| match self.metadata.channels {
            1 => self.verify_tile::<f32>(id),
            _ => self.verify_tile::<Rgb>(id),
        })
    }

    fn verify_tile<T: Transmittance>(&self, id: TileId) -> Result<()> {
        match StoredTile::read(&self.container, id, &self.limits)? {
            (Some(stored), _) => K::verify::<T>(stored, &self.keys),
            (None, _) => Ok(()),
        }
    }
}

/// Whether all levels are the finest of a view, of the same pixels.
fn has_same_pixels(levels: &[Level]) -> bool {
    let rect = |level: &Level| {
        [level.x, level.y]
            .map(i64::from)
            .into_iter()
            .chain([level.width, level.height].map(i64::from))
    };
    levels.iter().all(|level| level.number == 0 && rect(level).eq(rect(&levels[0])))
}

/// Refuses tolerances and errors of a map that has none.
fn check_exact(container: &Container) -> Result<()> {
    let refuse = |place| Err(Error::invalid(place, "maps of this kind have no errors"));
    for (index, level) in (0..).zip(container.levels()) {
        if level.tolerance != 0.0 || level.error != AchievedError::NONE {
            return refuse(Place::Level(index));
        }
        let wrong = |(_, entry): &(TileId, &TileEntry)| entry.error != AchievedError::NONE;
        if let Some((id, _)) = container.directory(index)?.iter().find(wrong) {
            return refuse(Place::Entry(id));
        }
    }
    Ok(())
}

/// Level 0 of a map with `T`'s channels.
struct FinestTiles<'a, K: MapKind, T> {
    map: &'a KindReader<K>,
    channels: PhantomData<T>,
}

impl<'a, K: MapKind, T> FinestTiles<'a, K, T> {
    const fn new(map: &'a KindReader<K>) -> Self {
        Self { map, channels: PhantomData }
    }
}

impl<K: MapKind, T: Transmittance> MapTiles for FinestTiles<'_, K, T> {
    type Tile = K::Tile<T>;

    fn metadata(&self) -> &Metadata {
        self.map.metadata()
    }

    fn directory(&self) -> Result<&TileDirectory> {
        self.map.directory(0)
    }

    fn for_each_tile(&self, visit: impl FnMut(TileRect, K::Tile<T>) -> Result<()>) -> Result<()> {
        self.map.for_each_tile::<T>(0, visit)
    }
}
