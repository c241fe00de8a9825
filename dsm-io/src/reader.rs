//! Reads deep maps.

use dsm_core::detail::PixelLists;
use dsm_core::{DeepMap, Transmittance};

use crate::any_deep_map::AnyDeepMap;
use crate::codec::Packing;
use crate::codec::stored_tile::StoredTile;
use crate::columns::Columns;
use crate::error::Result;
use crate::format::level::Level;
use crate::kind::deep::Deep;
use crate::kind::reader::KindReader;
use crate::tile::Tile;
use crate::tile_id::TileId;

/// An open deep map. Any number of threads may read from it.
///
/// ```no_run
/// use dsm_io::{Limits, MapReader};
/// use dsm_io::detail::TileId;
///
/// let reader = MapReader::open("shadow.dsm", &Limits::default())?;
/// let tile = reader.tile::<f32>(TileId::new(0, 0, 0))?;
/// println!("{}", tile.view().pixel(0, 0).at(4.5));
/// # Ok::<(), dsm_io::Error>(())
/// ```
pub type MapReader = KindReader<Deep>;

impl KindReader<Deep> {
    /// The pixels of a tile: checks its checksum and every function's
    /// invariant; decodes it, or gives a plain one where it lies. O(vertices).
    ///
    /// # Errors
    ///
    /// [`Error::Channels`](crate::error::Error::Channels) if `T` has another number of
    /// channels than the map, [`Error::NoSuchTile`](crate::error::Error::NoSuchTile), or
    /// what is wrong with the tile.
    pub fn tile<T: Transmittance>(&self, id: TileId) -> Result<Tile<'_, T>> {
        self.check_channels::<T>()?;
        self.container.in_file(self.read_tile(id))
    }

    fn read_tile<T: Transmittance>(&self, id: TileId) -> Result<Tile<'_, T>> {
        match StoredTile::read(&self.container, id, &self.limits)? {
            (Some(stored), _) => Deep::decode_in_place(stored),
            (None, rect) => Ok(Tile::Owned(PixelLists::clear(rect.width, rect.height))),
        }
    }

    /// How level 0's tiles are packed; `None` if all are empty. Tiles that
    /// packing didn't make smaller are plain among packed ones. O(tiles).
    ///
    /// # Errors
    ///
    /// As [`Self::directory`].
    pub(crate) fn packing(&self) -> Result<Option<Packing>> {
        let stored = self.directory(0)?.iter().filter(|(_, entry)| !entry.is_empty());
        // Plain is the lowest number.
        Ok(stored.map(|(_, entry)| entry.block).max().and_then(Packing::from_tag))
    }

    /// Reads a whole level into memory. Holds the level and one row of tiles.
    ///
    /// # Errors
    ///
    /// [`Error::Limit`](crate::error::Error::Limit) if the level has more pixels, bytes
    /// or values than a map in memory may have; else as [`Self::tile`].
    pub fn read_map<T: Transmittance>(&self, level: u32) -> Result<DeepMap<T>> {
        self.check_channels::<T>()?;
        self.check_in_memory(level)?;
        let pixels = self.container.level(level).and_then(|found| self.assemble(level, found));
        Ok(DeepMap::new(self.metadata().info, self.container.in_file(pixels)?))
    }

    fn assemble<T: Transmittance>(&self, index: u32, level: &Level) -> Result<PixelLists<T>> {
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
}

impl AnyDeepMap {
    /// Reads a level of a map.
    ///
    /// # Errors
    ///
    /// As [`MapReader::read_map`].
    pub fn read(reader: &MapReader, level: u32) -> Result<Self> {
        if reader.metadata().channels == 1 {
            reader.read_map(level).map(Self::Mono)
        } else {
            reader.read_map(level).map(Self::Rgb)
        }
    }
}
