//! Some whole pixel rows of a map, in the tiles that hold them.

use std::ops::Range;

use dsm_core::{Transmittance, VisibilityView};
use rayon::prelude::*;

use crate::{Level, MapReader, Result, Tile, TileId};

/// Some whole pixel rows of level 0 of a map.
pub(super) struct StoredRows<'a, T> {
    level: Level,
    /// The first row's number in the map.
    top: u32,
    /// Rows of tiles from the one with the first row, each from left to right;
    /// none where a tile is empty.
    tiles: Vec<Option<Tile<'a, T>>>,
}

impl<'a, T: Transmittance> StoredRows<'a, T> {
    /// Reads the tiles that hold `rows`, which lie in the map. An empty tile
    /// costs nothing.
    pub(super) fn read(map: &'a MapReader, rows: Range<u32>) -> Result<Self> {
        let level = map.levels()[0];
        let tile_rows = rows.start / level.tile_height..rows.end.div_ceil(level.tile_height);
        let columns = level.tiles()[0];
        let directory = map.directory(0)?;
        let ids: Vec<_> =
            tile_rows.flat_map(|y| (0..columns).map(move |x| TileId::new(0, x, y))).collect();
        let read = |id: TileId| {
            let is_empty = directory.get(id.x, id.y).is_some_and(|entry| entry.is_empty());
            if is_empty { Ok(None) } else { map.tile(id).map(Some) }
        };
        let tiles = ids.into_par_iter().map(read).collect::<Result<_>>()?;
        Ok(Self { level, top: rows.start, tiles })
    }

    /// The function of a pixel, counted row by row from the first of these.
    pub(super) fn function(&self, pixel: usize) -> VisibilityView<'_, T> {
        let width = self.level.width as usize;
        // Both are below the map's size.
        self.pixel((pixel % width) as u32, (pixel / width) as u32)
    }

    /// The function of the pixel in column `x` of the map and row `y`, counted
    /// from the first of these rows.
    pub(super) fn pixel(&self, x: u32, y: u32) -> VisibilityView<'_, T> {
        let Level { tile_width, tile_height, .. } = self.level;
        let y = self.top + y;
        match &self.tiles[self.index(x / tile_width, y / tile_height)] {
            Some(tile) => tile.view().pixel(x % tile_width, y % tile_height),
            None => VisibilityView::clear(),
        }
    }

    /// Whether only empty tiles hold these pixels; rows count from the first
    /// of these. O(tiles).
    pub(super) fn is_clear(&self, columns: Range<u32>, rows: Range<u32>) -> bool {
        let Level { tile_width, tile_height, .. } = self.level;
        let across = columns.start / tile_width..columns.end.div_ceil(tile_width);
        let (top, end) = (self.top + rows.start, self.top + rows.end);
        let mut down = top / tile_height..end.div_ceil(tile_height);
        down.all(|y| across.clone().all(|x| self.tiles[self.index(x, y)].is_none()))
    }

    fn index(&self, x: u32, y: u32) -> usize {
        let row = y - self.top / self.level.tile_height;
        row as usize * self.level.tiles()[0] as usize + x as usize
    }
}
