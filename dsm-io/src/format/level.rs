//! Levels: the rectangular pixel arrays of a file, each cut into tiles.

use super::{f32_at, field, put, reserved_is_valid, u32_at};
use crate::achieved_error::AchievedError;
use crate::error::{Error, Place, Result};
use crate::tile_id::{TileId, TileRect};

/// Length of a level's record, in bytes.
pub(super) const LEVEL_BYTES: usize = 64;

/// The largest width and height, in pixels.
const MAX_SIZE: u32 = i32::MAX as u32;

/// A level of a map: its size, its cut into tiles, and its error bound.
///
/// ```
/// use dsm_io::detail::Level;
///
/// // Tiles at the right and lower edge are smaller.
/// let level = Level::new(100, 50, 64, 0.01);
/// assert_eq!(level.tiles(), [2, 1]);
/// assert_eq!(level.tile_rect(1, 0).map(|rect| [rect.width, rect.height]), Some([36, 50]));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// The view that the level belongs to; 0 in a map of one view.
    pub view: u32,
    /// The level's number in its view's pyramid; 0 is the finest.
    pub number: u32,
    /// Width in pixels, at least 1.
    pub width: u32,
    /// Height in pixels, at least 1.
    pub height: u32,
    /// Column of the level's first pixel, in pixels of the level.
    pub x: i32,
    /// Row of the level's first pixel, in pixels of the level.
    pub y: i32,
    /// Width of a tile in pixels, at least 1.
    pub tile_width: u32,
    /// Height of a tile in pixels, at least 1.
    pub tile_height: u32,
    /// The L∞ bound that the level's functions keep, in [0, 1).
    pub tolerance: f32,
    /// The error that they have. The writer computes it from the tiles'.
    pub error: AchievedError,
}

impl Level {
    /// Level 0 of view 0, `width` × `height` pixels.
    #[must_use]
    pub const fn new(width: u32, height: u32, tile_size: u32, tolerance: f32) -> Self {
        Self {
            view: 0,
            number: 0,
            width,
            height,
            x: 0,
            y: 0,
            tile_width: tile_size,
            tile_height: tile_size,
            tolerance,
            error: AchievedError::NONE,
        }
    }

    /// Number of columns and of rows of tiles.
    #[must_use]
    pub const fn tiles(&self) -> [u32; 2] {
        [self.width.div_ceil(self.tile_width), self.height.div_ceil(self.tile_height)]
    }

    /// Number of tiles.
    #[must_use]
    pub const fn tile_count(&self) -> u64 {
        let [columns, rows] = self.tiles();
        columns as u64 * rows as u64
    }

    /// Number of pixels.
    #[must_use]
    pub const fn pixel_count(&self) -> u64 {
        self.width as u64 * self.height as u64
    }

    /// The pixels of the tile in column `x` and row `y`, if there is one.
    #[must_use]
    pub fn tile_rect(&self, x: u32, y: u32) -> Option<TileRect> {
        let [columns, rows] = self.tiles();
        if x >= columns || y >= rows {
            return None;
        }
        // Neither product can pass the level's size.
        let (left, top) = (x * self.tile_width, y * self.tile_height);
        Some(TileRect {
            x: left,
            y: top,
            width: self.tile_width.min(self.width - left),
            height: self.tile_height.min(self.height - top),
        })
    }

    /// The tile of this level, the one with index `index`, that holds a pixel, if
    /// there is one.
    pub(crate) fn tile_of(&self, index: u32, [x, y]: [u32; 2]) -> Option<TileId> {
        let is_inside = x < self.width && y < self.height;
        is_inside.then(|| TileId::new(index, x / self.tile_width, y / self.tile_height))
    }

    /// Which rule the level breaks, if any.
    pub(crate) fn broken_rule(&self) -> Option<&'static str> {
        let sizes = [self.width, self.height, self.tile_width, self.tile_height];
        if sizes.iter().any(|size| !(1..=MAX_SIZE).contains(size)) {
            return Some("sizes and tile sizes must lie between 1 and 2³¹ − 1");
        }
        if !(0.0..1.0).contains(&self.tolerance) {
            return Some("the tolerance must lie in [0, 1)");
        }
        self.error.broken_rule()
    }

    /// The record of a level whose tile directory is section `directory`.
    pub(super) fn encode(&self, directory: u32) -> [u8; LEVEL_BYTES] {
        let mut bytes = [0; LEVEL_BYTES];
        put(&mut bytes, 0, self.view.to_le_bytes());
        put(&mut bytes, 4, self.number.to_le_bytes());
        put(&mut bytes, 8, self.width.to_le_bytes());
        put(&mut bytes, 12, self.height.to_le_bytes());
        put(&mut bytes, 16, self.x.to_le_bytes());
        put(&mut bytes, 20, self.y.to_le_bytes());
        put(&mut bytes, 24, self.tile_width.to_le_bytes());
        put(&mut bytes, 28, self.tile_height.to_le_bytes());
        put(&mut bytes, 32, self.tolerance.to_le_bytes());
        put(&mut bytes, 36, self.error.max.to_le_bytes());
        put(&mut bytes, 40, self.error.mean.to_le_bytes());
        put(&mut bytes, 44, directory.to_le_bytes());
        bytes
    }

    /// The level of record `index`, and the section of its tile directory.
    pub(super) fn decode(bytes: &[u8], index: u32, minor: u16) -> Result<(Self, u32)> {
        let place = Place::Level(index);
        let level = Self {
            view: u32_at(bytes, 0),
            number: u32_at(bytes, 4),
            width: u32_at(bytes, 8),
            height: u32_at(bytes, 12),
            x: i32::from_le_bytes(field(bytes, 16)),
            y: i32::from_le_bytes(field(bytes, 20)),
            tile_width: u32_at(bytes, 24),
            tile_height: u32_at(bytes, 28),
            tolerance: f32_at(bytes, 32),
            error: AchievedError { max: f32_at(bytes, 36), mean: f32_at(bytes, 40) },
        };
        if let Some(reason) = level.broken_rule() {
            return Err(Error::invalid(place, reason));
        }
        if !reserved_is_valid(&bytes[48..], minor) {
            return Err(Error::invalid(place, "reserved bytes are not zero"));
        }
        Ok((level, u32_at(bytes, 44)))
    }
}

/// Which rule the order of a file's levels breaks, if any: views count from
/// 0, and so do the levels of each.
pub(super) fn broken_order(levels: &[Level]) -> Option<(u32, &'static str)> {
    let mut expected = [0, 0];
    for (index, level) in (0..).zip(levels) {
        let found = [level.view, level.number];
        let next_view = index > 0 && found == [expected[0] + 1, 0];
        if found != expected && !next_view {
            return Some((index, "levels must stand in the order of their views and numbers"));
        }
        expected = [level.view, level.number + 1];
    }
    None
}
