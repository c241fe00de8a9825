//! Work on the tiles of several maps at once, a block of pixels at a time.

use crate::achieved_error::AchievedError;
use crate::error::Result;
use crate::format::level::Level;
use crate::reader::MapReader;
use crate::tile_id::{TileId, TileRect};

/// Blocks that are in memory at a time, for each thread.
pub(crate) const BLOCKS_A_THREAD: u64 = 2;

/// A level cut into blocks, row by row. Each is of whole tiles of one map and
/// not smaller than the largest tile of any: so no tile lies in more than
/// four blocks, and where all have tiles of one size each lies in one.
pub(crate) struct Blocks {
    size: [u32; 2],
    block: [u32; 2],
}

impl Blocks {
    /// The blocks of levels of one size; they are of whole tiles of the
    /// first.
    pub(crate) fn new<'a>(first: &Level, others: impl IntoIterator<Item = &'a Level>) -> Self {
        let unit = [first.tile_width, first.tile_height];
        let largest = others.into_iter().fold(unit, |[width, height], level| {
            [width.max(level.tile_width), height.max(level.tile_height)]
        });
        let size = [first.width, first.height];
        let block = [0, 1].map(|axis| {
            let whole = u64::from(largest[axis]).next_multiple_of(unit[axis].into());
            // Not above the level's size.
            whole.min(size[axis].into()) as u32
        });
        Self { size, block }
    }

    fn columns(&self) -> u64 {
        self.size[0].div_ceil(self.block[0]).into()
    }

    /// Number of blocks.
    pub(crate) fn count(&self) -> u64 {
        self.columns() * u64::from(self.size[1].div_ceil(self.block[1]))
    }

    /// The pixels of block `index`, which is below [`Self::count`].
    pub(crate) fn rect(&self, index: u64) -> TileRect {
        let [width, height] = self.block;
        // Both products lie inside the level.
        let x = (index % self.columns()) as u32 * width;
        let y = (index / self.columns()) as u32 * height;
        TileRect { x, y, width: width.min(self.size[0] - x), height: height.min(self.size[1] - y) }
    }
}

/// The ids of a level's tiles that a rectangle inside it touches, row by row.
pub(crate) fn tiles_of(
    index: u32,
    level: &Level,
    rect: TileRect,
) -> impl Iterator<Item = TileId> + use<> {
    let range = |first: u32, length: u32, tile: u32| first / tile..(first + length).div_ceil(tile);
    let columns = range(rect.x, rect.width, level.tile_width);
    let rows = range(rect.y, rect.height, level.tile_height);
    rows.flat_map(move |y| columns.clone().map(move |x| TileId::new(index, x, y)))
}

/// Whether a level is 1 everywhere in a rectangle, as far as its directory
/// knows. O(tiles).
pub(crate) fn is_empty(map: &MapReader, index: u32, rect: TileRect) -> Result<bool> {
    let (level, directory) = (map.container().level(index)?, map.directory(index)?);
    let mut entries = tiles_of(index, level, rect).filter_map(|id| directory.get(id.x, id.y));
    Ok(entries.all(|entry| entry.is_empty()))
}

/// The largest error that a level states in a rectangle, and the mean error of
/// its tiles there.
pub(crate) fn stated_error(map: &MapReader, index: u32, rect: TileRect) -> Result<AchievedError> {
    let (level, directory) = (map.container().level(index)?, map.directory(index)?);
    let shared = |a: u32, a_length: u32, b: u32, b_length: u32| {
        u64::from((a + a_length).min(b + b_length) - a.max(b))
    };
    let parts = tiles_of(index, level, rect).filter_map(|id| {
        let (entry, tile) = (directory.get(id.x, id.y)?, level.tile_rect(id.x, id.y)?);
        let width = shared(rect.x, rect.width, tile.x, tile.width);
        let height = shared(rect.y, rect.height, tile.y, tile.height);
        Some((entry.error, width * height))
    });
    Ok(AchievedError::of_parts(parts))
}

/// How far depths of a level were moved away from the light in a rectangle at
/// most, as its directory states.
pub(crate) fn stated_depth_error(map: &MapReader, index: u32, rect: TileRect) -> Result<f32> {
    let (level, directory) = (map.container().level(index)?, map.directory(index)?);
    let entries = tiles_of(index, level, rect).filter_map(|id| directory.get(id.x, id.y));
    Ok(entries.map(|entry| entry.depth_error).fold(0.0, f32::max))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level(size: [u32; 2], tile: [u32; 2]) -> Level {
        let level = Level::new(size[0], size[1], 1, 0.0);
        Level { tile_width: tile[0], tile_height: tile[1], ..level }
    }

    #[test]
    fn blocks_cover_every_pixel_once_and_hold_whole_tiles() {
        for (size, tile, other) in [
            ([7, 5], [2, 2], [2, 2]),
            ([7, 5], [2, 3], [5, 1]),
            ([7, 5], [3, 3], [100, 100]),
            ([1, 1], [4, 4], [1, 1]),
            ([64, 33], [8, 8], [12, 20]),
        ] {
            let first = level(size, tile);
            let blocks = Blocks::new(&first, [&level(size, other)]);
            let mut count = vec![0; (size[0] * size[1]) as usize];
            for rect in (0..blocks.count()).map(|index| blocks.rect(index)) {
                assert_eq!([rect.x % tile[0], rect.y % tile[1]], [0, 0], "{rect:?}");
                for (y, x) in (0..rect.height).flat_map(|y| (0..rect.width).map(move |x| (y, x))) {
                    count[((rect.y + y) * size[0] + rect.x + x) as usize] += 1;
                }
                let least = [0, 1].map(|axis| other[axis].min(size[axis]));
                let at_edge = [rect.x + rect.width == size[0], rect.y + rect.height == size[1]];
                assert!(at_edge[0] || rect.width >= least[0], "{rect:?}");
                assert!(at_edge[1] || rect.height >= least[1], "{rect:?}");
            }
            assert!(count.iter().all(|&times| times == 1), "{size:?} {tile:?} {other:?}");
        }
    }

    #[test]
    fn the_tiles_of_a_rectangle_are_those_it_touches() {
        let rect = TileRect { x: 3, y: 0, width: 3, height: 5 };
        let ids: Vec<_> = tiles_of(1, &level([9, 9], [4, 4]), rect).collect();
        let expected = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| TileId::new(1, x, y));
        assert_eq!(ids, expected);
    }
}
