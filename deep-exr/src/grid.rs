//! The chunks of an image.

/// Grid of blocks (tiles, or scan lines over the whole width) of the largest
/// level, which come first in the offset table, row by row.
///
/// ```
/// use deep_exr::{Layout, WriteOptions};
///
/// let tiles = Layout::Tiles { width: 4, height: 3 };
/// let grid = WriteOptions::new(10, 7).layout(tiles).grid()?;
/// assert_eq!((grid.columns(), grid.bands(), grid.rows(2)), (3, 3, 6..7));
/// let corner = grid.block(2, 2);
/// assert_eq!([corner.x, corner.y, corner.width, corner.height], [8, 6, 2, 1]);
/// # Ok::<(), deep_exr::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct ChunkGrid {
    size: [u32; 2],
    block: [u32; 2],
    tiled: bool,
    origin: [i32; 2],
}

/// Block of a [`ChunkGrid`]: its place in the grid, and the pixels it covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Block {
    /// Its column of blocks.
    pub column: u32,
    /// Its row of blocks.
    pub band: u32,
    /// Its first pixel column, from the left of the data window.
    pub x: u32,
    /// Its first pixel row, from the top of the data window.
    pub y: u32,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
}

impl Block {
    pub(crate) fn pixels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }
}

impl ChunkGrid {
    /// `origin` is the corner of the data window. All sizes are at least 1.
    pub(crate) fn new(size: [u32; 2], block: [u32; 2], tiled: bool, origin: [i32; 2]) -> Self {
        Self { size, block: [block[0].min(1 << 30), block[1].min(1 << 30)], tiled, origin }
    }

    pub(crate) fn width(&self) -> u32 {
        self.size[0]
    }

    pub(crate) fn height(&self) -> u32 {
        self.size[1]
    }

    pub(crate) fn is_tiled(&self) -> bool {
        self.tiled
    }

    /// Pixels of a block that no edge cuts.
    pub(crate) fn whole_block(&self) -> [u32; 2] {
        self.block
    }

    /// Number of blocks side by side.
    #[must_use]
    pub fn columns(&self) -> u32 {
        self.size[0].div_ceil(self.block[0])
    }

    /// Number of rows of blocks.
    #[must_use]
    pub fn bands(&self) -> u32 {
        self.size[1].div_ceil(self.block[1])
    }

    /// The row of blocks that holds the pixel row `y`.
    pub(crate) fn band_of(&self, y: u32) -> u32 {
        y / self.block[1]
    }

    /// The pixel rows of a row of blocks; none beyond the image.
    #[must_use]
    pub fn rows(&self, band: u32) -> std::ops::Range<u32> {
        let first = band.saturating_mul(self.block[1]).min(self.size[1]);
        first..self.size[1].min(first + self.block[1])
    }

    /// The block in this column and row of blocks; one without pixels beyond the
    /// image.
    #[must_use]
    pub fn block(&self, column: u32, band: u32) -> Block {
        let x = column.saturating_mul(self.block[0]).min(self.size[0]);
        let rows = self.rows(band);
        Block {
            column,
            band,
            x,
            y: rows.start,
            width: self.block[0].min(self.size[0] - x),
            height: rows.len() as u32,
        }
    }

    /// Place in the offset table.
    pub(crate) fn index(&self, block: &Block) -> usize {
        block.band as usize * self.columns() as usize + block.column as usize
    }

    /// Number of blocks.
    pub(crate) fn count(&self) -> u64 {
        u64::from(self.columns()) * u64::from(self.bands())
    }

    /// The numbers that the block's chunk must start with: the line in the
    /// data window's coordinates, or tile and level.
    pub(crate) fn coordinates(&self, block: &Block) -> ([i32; 4], usize) {
        if self.tiled {
            ([block.column as i32, block.band as i32, 0, 0], 4)
        } else {
            ([self.origin[1] + block.y as i32, 0, 0, 0], 1)
        }
    }

    /// The place in the offset table of the block whose chunk starts with these
    /// numbers: `None` for one that the grid does not have.
    pub(crate) fn index_of(&self, numbers: [i32; 4]) -> Option<usize> {
        let (column, band) = if self.tiled {
            let [column, band, 0, 0] = numbers else { return None };
            (u32::try_from(column).ok()?, u32::try_from(band).ok()?)
        } else {
            let row = i64::from(numbers[0]) - i64::from(self.origin[1]);
            let row = u32::try_from(row).ok()?;
            if !row.is_multiple_of(self.block[1]) {
                return None;
            }
            (0, self.band_of(row))
        };
        (column < self.columns() && band < self.bands())
            .then(|| self.index(&self.block(column, band)))
    }

    /// The block, for messages.
    pub(crate) fn describe(&self, block: &Block) -> String {
        if self.tiled {
            format!("tile ({}, {})", block.column, block.band)
        } else {
            format!("scan line {}", self.origin[1] + block.y as i32)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edge_tiles_are_cut_and_counted_row_by_row() {
        let grid = ChunkGrid::new([10, 7], [4, 3], true, [-2, 5]);
        assert_eq!((grid.columns(), grid.bands(), grid.count()), (3, 3, 9));
        let corner = grid.block(2, 2);
        assert_eq!(corner, Block { column: 2, band: 2, x: 8, y: 6, width: 2, height: 1 });
        assert_eq!(grid.index(&corner), 8);
        assert_eq!(grid.coordinates(&corner), ([2, 2, 0, 0], 4));
        assert_eq!((grid.band_of(5), grid.rows(1)), (1, 3..6));
    }

    #[test]
    fn scan_lines_are_numbered_from_the_data_window() {
        let grid = ChunkGrid::new([10, 7], [10, 1], false, [-2, -3]);
        let line = grid.block(0, 4);
        assert_eq!(grid.coordinates(&line), ([1, 0, 0, 0], 1));
        assert_eq!(grid.describe(&line), "scan line 1");
    }
}
