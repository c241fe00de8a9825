//! The functions of a rectangle of a map, in the tiles that hold them.

use std::ops::Range;

use dsm_core::detail::{SumVertex, VisibilityView};
use dsm_core::{Transmittance, Vertex};
use rayon::prelude::*;

use crate::blocks::tiles_of;
use crate::error::Result;
use crate::reader::MapReader;
use crate::tile::Tile;
use crate::tile_id::TileRect;

/// The functions of a rectangle of a level, decoded but for empty tiles. Pixels
/// go by their place in the level.
pub(crate) struct Region<'a, T> {
    rect: TileRect,
    tile: [u32; 2],
    /// Column and row of the first tile, and number of columns.
    first: [u32; 2],
    columns: usize,
    tiles: Vec<Option<Tile<'a, T>>>,
}

impl<'a, T: Transmittance> Region<'a, T> {
    /// Reads the tiles that `rect` touches, which lies inside the level; in
    /// parallel. An empty tile costs nothing.
    pub(crate) fn read(map: &'a MapReader, index: u32, rect: TileRect) -> Result<Self> {
        let (level, directory) = (map.container().level(index)?, map.directory(index)?);
        let tile = [level.tile_width, level.tile_height];
        let first = [rect.x / tile[0], rect.y / tile[1]];
        let columns = ((rect.x + rect.width).div_ceil(tile[0]) - first[0]) as usize;
        let tiles = tiles_of(index, level, rect)
            .collect::<Vec<_>>()
            .into_par_iter()
            .map(|id| match directory.get(id.x, id.y) {
                Some(entry) if !entry.is_empty() => map.tile(id).map(Some),
                _ => Ok(None),
            })
            .collect::<Result<_>>()?;
        Ok(Self { rect, tile, first, columns, tiles })
    }

    /// Reads whole rows of level 0.
    pub(crate) fn read_rows(map: &'a MapReader, rows: Range<u32>) -> Result<Self> {
        let width = map.levels()[0].width;
        let rect = TileRect { x: 0, y: rows.start, width, height: rows.len() as u32 };
        Self::read(map, 0, rect)
    }

    /// The rectangle.
    pub(crate) const fn rect(&self) -> TileRect {
        self.rect
    }

    /// The function of a pixel of the rectangle; `None` if its tile is 1
    /// everywhere.
    pub(crate) fn function(&self, x: u32, y: u32) -> Option<VisibilityView<'_, T>> {
        let [width, height] = self.tile;
        let tile = self.tiles[self.index(x / width, y / height)].as_ref()?;
        Some(tile.view().pixel(x % width, y % height))
    }

    /// Whether only empty tiles hold these pixels of the rectangle. O(tiles).
    pub(crate) fn is_clear(&self, columns: Range<u32>, rows: Range<u32>) -> bool {
        let [width, height] = self.tile;
        let across = columns.start / width..columns.end.div_ceil(width);
        let mut down = rows.start / height..rows.end.div_ceil(height);
        down.all(|y| across.clone().all(|x| self.tiles[self.index(x, y)].is_none()))
    }

    fn index(&self, x: u32, y: u32) -> usize {
        (y - self.first[1]) as usize * self.columns + (x - self.first[0]) as usize
    }
}

/// The functions of a rectangle, of a map with as many channels as `T` or one.
pub(crate) enum AnyRegion<'a, T> {
    Same(Region<'a, T>),
    /// One channel that stands for all.
    Mono(Region<'a, f32>),
}

impl<'a, T: Transmittance> AnyRegion<'a, T> {
    /// As [`Region::read`].
    pub(crate) fn read(map: &'a MapReader, index: u32, rect: TileRect) -> Result<Self> {
        if usize::from(map.metadata().channels) == T::CHANNELS {
            Region::read(map, index, rect).map(Self::Same)
        } else {
            Region::read(map, index, rect).map(Self::Mono)
        }
    }

    /// Replaces `vertices` by those of a pixel.
    pub(crate) fn copy_function(&self, x: u32, y: u32, vertices: &mut Vec<SumVertex<T>>) {
        vertices.clear();
        match self {
            Self::Same(region) => {
                let function = region.function(x, y).into_iter();
                let all = function.flat_map(VisibilityView::vertices);
                vertices.extend(all.map(|vertex| Vertex::new(vertex.z, vertex.value.to_sum())));
            }
            Self::Mono(region) => {
                let function = region.function(x, y).into_iter();
                let all = function.flat_map(VisibilityView::vertices);
                vertices.extend(
                    all.map(|vertex| Vertex::new(vertex.z, T::splat(vertex.value).to_sum())),
                );
            }
        }
    }
}
