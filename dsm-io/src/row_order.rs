//! Tiles that come row by row, into pixels that do.

use crate::map_tile::MapTile;

/// Collects the tiles of a map, a row of them at a time, and hands their pixels
/// on in the order of the map.
#[derive(Debug)]
pub struct RowOrder<P> {
    columns: usize,
    row: Vec<P>,
}

impl<P: MapTile> RowOrder<P> {
    /// Rows of so many tiles.
    pub const fn new(columns: usize) -> Self {
        Self { columns, row: Vec::new() }
    }

    /// Takes the next tile; `take` gets a tile and the row-major index of one of
    /// its pixels, when a row of tiles is complete.
    ///
    /// # Errors
    ///
    /// The first of `take`.
    pub fn push<E>(
        &mut self,
        tile: P,
        mut take: impl FnMut(&P, usize) -> Result<(), E>,
    ) -> Result<(), E> {
        self.row.push(tile);
        if self.row.len() < self.columns {
            return Ok(());
        }
        for y in 0..self.row.first().map_or(0, |tile| tile.size()[1]) {
            for tile in &self.row {
                let width = tile.size()[0] as usize;
                for x in 0..width {
                    take(tile, y as usize * width + x)?;
                }
            }
        }
        self.row.clear();
        Ok(())
    }
}
