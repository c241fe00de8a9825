//! Tile directories: where each tile of a level stands, and what is in it.

use super::extent::Extent;
use super::level::Level;
use super::{f32_at, put, reserved_is_valid, u32_at, u64_at};
use crate::achieved_error::AchievedError;
use crate::error::{Error, Place, Result};
use crate::tile_id::{TileId, TileRect};

/// Length of a directory entry, in bytes.
pub(super) const ENTRY_BYTES: usize = 64;

/// The directory entry of a tile. A tile that is 1 everywhere has no
/// payload and no vertices.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TileEntry {
    /// The payload's offset in the file, in bytes; 0 if there is none.
    pub offset: u64,
    /// Length of the payload in the file, in bytes.
    pub stored_length: u64,
    /// Length of the payload once unpacked, in bytes.
    pub raw_length: u64,
    /// Number of vertices in all pixels.
    pub vertex_count: u64,
    /// The smallest depth of all vertices.
    pub z_min: f32,
    /// The largest depth of all vertices.
    pub z_max: f32,
    /// The error that the tile's functions have.
    pub error: AchievedError,
    /// The maximum shift of depths away from the light; 0 where they
    /// are exact.
    pub depth_error: f32,
    /// The number of the columns' codec.
    pub codec: u8,
    /// The number of the columns' packing.
    pub block: u8,
    /// The columns that are stored as differences: bit i for column i.
    pub differences: u8,
    /// CRC-32C of the payload and its padding.
    pub crc: u32,
}

impl TileEntry {
    /// True if the tile is 1 everywhere.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.offset == 0
    }

    pub(super) const fn extent(&self) -> Extent {
        Extent { offset: self.offset, length: self.stored_length, crc: self.crc }
    }

    /// Where the tile's payload stands.
    pub(crate) const fn place(&self, id: TileId) -> Place {
        Place::Tile { id, offset: self.offset }
    }

    /// Which rule the entry breaks, if any.
    pub(super) fn broken_rule(&self) -> Option<&'static str> {
        let no_payload = Self { error: self.error, ..Self::default() };
        if self.is_empty() && *self != no_payload {
            return Some("an empty tile must have nothing but its error");
        }
        if !self.is_empty() && (self.stored_length == 0 || self.raw_length == 0) {
            return Some("a tile that is not empty must have a payload");
        }
        let is_depth = |z: f32| (0.0..f32::INFINITY).contains(&z);
        if ![self.z_min, self.z_max, self.depth_error].into_iter().all(is_depth)
            || self.z_min > self.z_max
        {
            return Some("depths must be finite and at least 0, and ordered");
        }
        self.error.broken_rule()
    }

    pub(super) fn encode(&self) -> [u8; ENTRY_BYTES] {
        let mut bytes = [0; ENTRY_BYTES];
        put(&mut bytes, 0, self.offset.to_le_bytes());
        put(&mut bytes, 8, self.stored_length.to_le_bytes());
        put(&mut bytes, 16, self.raw_length.to_le_bytes());
        put(&mut bytes, 24, self.vertex_count.to_le_bytes());
        put(&mut bytes, 32, self.z_min.to_le_bytes());
        put(&mut bytes, 36, self.z_max.to_le_bytes());
        put(&mut bytes, 40, self.error.max.to_le_bytes());
        put(&mut bytes, 44, self.error.mean.to_le_bytes());
        put(&mut bytes, 48, self.depth_error.to_le_bytes());
        put(&mut bytes, 52, self.crc.to_le_bytes());
        put(&mut bytes, 56, [self.codec, self.block, self.differences]);
        bytes
    }

    fn decode(bytes: &[u8], id: TileId, minor: u16, file_length: u64) -> Result<Self> {
        let place = Place::Entry(id);
        let entry = Self {
            offset: u64_at(bytes, 0),
            stored_length: u64_at(bytes, 8),
            raw_length: u64_at(bytes, 16),
            vertex_count: u64_at(bytes, 24),
            z_min: f32_at(bytes, 32),
            z_max: f32_at(bytes, 36),
            error: AchievedError { max: f32_at(bytes, 40), mean: f32_at(bytes, 44) },
            depth_error: f32_at(bytes, 48),
            crc: u32_at(bytes, 52),
            codec: bytes[56],
            block: bytes[57],
            differences: bytes[58],
        };
        if let Some(reason) = entry.broken_rule() {
            return Err(Error::invalid(place, reason));
        }
        if !reserved_is_valid(&bytes[59..], minor) {
            return Err(Error::invalid(place, "reserved bytes are not zero"));
        }
        entry.extent().check_inside(file_length, place)?;
        Ok(entry)
    }
}

/// The tiles of one level, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct TileDirectory {
    level: u32,
    columns: u32,
    entries: Vec<TileEntry>,
}

impl TileDirectory {
    /// A directory of empty tiles.
    pub(super) fn clear(level: u32, [columns, rows]: [u32; 2]) -> Self {
        let count = columns as usize * rows as usize;
        Self { level, columns, entries: vec![TileEntry::default(); count] }
    }

    /// Reads the entries of the level with index `level`; `bytes` hold one
    /// for each of its tiles.
    pub(super) fn decode(
        bytes: &[u8],
        (level, columns): (u32, u32),
        minor: u16,
        file_length: u64,
    ) -> Result<Self> {
        let entries = bytes.chunks_exact(ENTRY_BYTES).zip(0u64..).map(|(entry, index)| {
            let (y, x) = (index / u64::from(columns), index % u64::from(columns));
            // Both are below the level's size.
            TileEntry::decode(entry, TileId::new(level, x as u32, y as u32), minor, file_length)
        });
        Ok(Self { level, columns, entries: entries.collect::<Result<_>>()? })
    }

    /// The entry of the tile in column `x` and row `y`, if there is one.
    #[must_use]
    pub fn get(&self, x: u32, y: u32) -> Option<&TileEntry> {
        self.entries.get(self.index(x, y)?)
    }

    pub(super) fn get_mut(&mut self, x: u32, y: u32) -> Option<&mut TileEntry> {
        let index = self.index(x, y)?;
        self.entries.get_mut(index)
    }

    /// The error of `level`, whose tiles these are.
    pub(crate) fn error_of(&self, level: &Level) -> AchievedError {
        AchievedError::of_parts(self.iter().map(|(id, entry)| {
            let pixels = level.tile_rect(id.x, id.y).map_or(0, TileRect::pixel_count);
            (entry.error, pixels)
        }))
    }

    fn index(&self, x: u32, y: u32) -> Option<usize> {
        (x < self.columns).then(|| y as usize * self.columns as usize + x as usize)
    }

    /// All tiles and their entries, row by row.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (TileId, &TileEntry)> {
        self.entries.iter().enumerate().map(|(index, entry)| {
            let columns = self.columns as usize;
            // Both are below the level's size.
            let (x, y) = ((index % columns) as u32, (index / columns) as u32);
            (TileId::new(self.level, x, y), entry)
        })
    }
}
