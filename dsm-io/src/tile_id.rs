//! Names of tiles, and the pixels they cover.

use std::fmt;

/// A tile of a level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TileId {
    /// Index of the level among the file's level records.
    pub level: u32,
    /// Column of the tile.
    pub x: u32,
    /// Row of the tile.
    pub y: u32,
}

impl TileId {
    /// The tile in column `x` and row `y` of the level with index `level`.
    #[must_use]
    pub const fn new(level: u32, x: u32, y: u32) -> Self {
        Self { level, x, y }
    }
}

impl fmt::Display for TileId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "tile ({}, {}) of level {}", self.x, self.y, self.level)
    }
}

/// The pixels of its level that a tile covers.
///
/// ```
/// use dsm_io::detail::TileRect;
///
/// assert_eq!(TileRect { x: 64, y: 0, width: 36, height: 50 }.pixel_count(), 1800);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileRect {
    /// First column.
    pub x: u32,
    /// First row.
    pub y: u32,
    /// Width in pixels; less than the tile size at the right edge.
    pub width: u32,
    /// Height in pixels; less than the tile size at the lower edge.
    pub height: u32,
}

impl TileRect {
    /// Number of pixels.
    #[must_use]
    pub const fn pixel_count(self) -> u64 {
        self.width as u64 * self.height as u64
    }
}
