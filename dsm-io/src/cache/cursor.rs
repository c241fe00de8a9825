//! One thread's way into a cached map.

use std::cell::Cell;
use std::fmt;
use std::ops::Range;

use dsm_core::detail::BlockVisitor;
use dsm_core::{Transmittance, VisibilityField};

use super::map::CachedMap;
use super::rows_ahead::{RowsAhead, Step};
use super::slot::{Slot, evaluate_block, evaluate_run, take_clear, within};
use super::tile_division::TileDivision;
use crate::error::{Error, Result};
use crate::format::level::Level;
use crate::kind::deep::Deep;
use crate::kind::map_kind::{FieldKind, MapKind};
use crate::map_tile::MapTile;
use crate::tile_id::TileId;

/// Slots of a cursor. They stand in lines of 16, or of as many as a level has
/// columns of tiles, if those are fewer: all tiles of a level of 256 have a slot
/// each (1024² pixels in tiles of 64²), and tiles that lie less than a line
/// apart in x, and 16 in y, never share one, so a footprint over a corner where
/// four tiles meet keeps all four.
const SLOTS: u32 = 256;
/// The logarithm of a line's slots, at most.
const MOST_SLOT_COLUMNS: u32 = 4;

/// Looks up one level of a [`CachedMap`], for one thread: a field of filtered
/// lookups for kinds that are such ([`FieldKind`]), and [`Self::with_pixel`] for
/// all.
///
/// It holds on to the tiles it was asked for last, up to 256, one for each
/// position modulo 16 × 16, or fewer columns and more rows in a level that has
/// fewer columns of tiles. A pixel of those costs no lock, and nothing that
/// another thread writes; any other pixel costs one, and a load if nobody
/// holds its tile. Make one cursor a thread and keep it: a new one begins with
/// no tile. Held tiles are not in the budget: t cursors hold up to 256 t tiles
/// more ([`CacheStatistics::pinned_bytes`](crate::cache::statistics::CacheStatistics)), but none
/// more than 128 MiB of them, or one tile where that is larger.
///
/// The values are bit for bit those of the map read into memory.
///
/// ```no_run
/// use dsm_core::{Filter, FilterShape, Footprint, Receiver, filtered_lookup};
/// use dsm_io::detail::TileCache;
/// use dsm_io::Limits;
///
/// let cache = TileCache::new(256 << 20);
/// let map = cache.open::<f32>("shadow.dsm", &Limits::default())?;
/// let cursor = map.cursor();
/// let footprint = Footprint::Isotropic(Filter::new(FilterShape::Tent, 4.0)?);
/// let light = filtered_lookup(&cursor, &Receiver::new([10.5, 7.25], 4.0), &footprint)?;
/// # Ok::<(), dsm_io::Error>(())
/// ```
pub struct LookupCursor<T: Transmittance, K: MapKind = Deep> {
    map: CachedMap<T, K>,
    level: u32,
    size: [u32; 2],
    columns: TileDivision,
    rows: TileDivision,
    /// The logarithm of the slots in a line.
    slot_columns: u32,
    /// A tile is out of its slot while its pixels are looked at.
    slots: [Cell<Slot<K::Tile<T>>>; SLOTS as usize],
    /// Of each slot's tile, which rows are on their way from memory.
    rows_ahead: [RowsAhead; SLOTS as usize],
    /// Where the last block began.
    last: Cell<[u32; 2]>,
    /// Bytes of the tiles in the slots, and how many there may be.
    held_bytes: Cell<u64>,
    most_held_bytes: u64,
    hits: Cell<u64>,
}

/// Bytes of tiles that a cursor holds: as many as 256 usual ones.
const MOST_HELD_BYTES: u64 = 128 << 20;

impl<T: Transmittance, K: MapKind> LookupCursor<T, K> {
    pub(super) fn new(map: CachedMap<T, K>, index: u32, level: &Level) -> Self {
        Self {
            map,
            level: index,
            size: [level.width, level.height],
            columns: TileDivision::new(level.tile_width),
            rows: TileDivision::new(level.tile_height),
            slot_columns: slot_columns(level.width.div_ceil(level.tile_width)),
            slots: std::array::from_fn(|_| Cell::new(Slot::VACANT)),
            rows_ahead: std::array::from_fn(|_| RowsAhead::default()),
            last: Cell::new([u32::MAX; 2]),
            held_bytes: Cell::new(0),
            most_held_bytes: MOST_HELD_BYTES,
            hits: Cell::new(0),
        }
    }

    /// The map that is looked up.
    #[must_use]
    pub const fn map(&self) -> &CachedMap<T, K> {
        &self.map
    }

    /// Index of the level that is looked up.
    #[must_use]
    pub const fn level(&self) -> u32 {
        self.level
    }

    /// Lets go of all tiles and hands the hits in to the statistics.
    pub fn release(&self) {
        self.vacate();
        self.map.hand_in(&self.hits);
    }

    fn vacate(&self) {
        self.slots.iter().for_each(|slot| slot.set(Slot::VACANT));
        self.held_bytes.set(0);
    }

    /// Width and height of the level in pixels.
    #[must_use]
    pub const fn level_size(&self) -> [u32; 2] {
        self.size
    }

    /// Calls `look` with the tile that holds a pixel and the pixel's row-major index
    /// there, and returns its result. No tile: it is empty. O(1) besides, if the tile is held.
    ///
    /// # Errors
    ///
    /// As [`CachedMap::tile`]; [`Error::NoSuchPixel`] if the pixel lies outside.
    #[inline]
    pub fn with_pixel<R>(
        &self,
        [x, y]: [u32; 2],
        look: impl FnOnce(Option<&K::Tile<T>>, usize) -> R,
    ) -> Result<R> {
        if x >= self.size[0] || y >= self.size[1] {
            return Err(Self::outside([x, y]));
        }
        let ((column, x), (row, y)) = (self.columns.split(x), self.rows.split(y));
        self.with_tile([column, row], |tile| {
            let width = tile.map_or(0, |tile| tile.size()[0] as usize);
            (look(tile, y as usize * width + x as usize), 1)
        })
    }

    /// What `look` makes of a tile's pixels, and of how many it says. No
    /// pixels: the tile is empty.
    #[inline(always)]
    fn with_tile<R>(
        &self,
        tile: [u32; 2],
        look: impl FnOnce(Option<&K::Tile<T>>) -> (R, u64),
    ) -> Result<R> {
        let slot = &self.slots[self.slot_of(tile)];
        let mut held = slot.replace(Slot::VACANT);
        // A tile that is fetched is counted where it is found.
        let mut counted = 0;
        if held.tile != tile {
            held = self.fetch(tile, held)?;
            counted = 1;
        }
        let (result, pixels) = look(held.tile());
        slot.set(held);
        self.hits.update(|hits| hits + pixels - counted);
        Ok(result)
    }

    /// The tile in place of the one that was in its slot.
    #[cold]
    #[inline(never)]
    fn fetch(&self, tile: [u32; 2], before: Slot<K::Tile<T>>) -> Result<Slot<K::Tile<T>>> {
        self.held_bytes.update(|held| held.saturating_sub(before.bytes()));
        drop(before);
        self.rows_ahead[self.slot_of(tile)].forget();
        let id = TileId::new(self.level, tile[0], tile[1]);
        let slot = Slot { tile, pixels: self.map.tile_after(id, &self.hits)? };
        if self.held_bytes.get().saturating_add(slot.bytes()) > self.most_held_bytes {
            self.vacate();
        }
        self.held_bytes.update(|held| held + slot.bytes());
        Ok(slot)
    }

    #[inline(always)]
    const fn slot_of(&self, tile: [u32; 2]) -> usize {
        slot_of(tile, self.slot_columns)
    }

    #[cold]
    #[inline(never)]
    fn outside(pixel: [u32; 2]) -> Error {
        Error::NoSuchPixel(pixel)
    }
}

impl<T: Transmittance, K: FieldKind> VisibilityField for LookupCursor<T, K> {
    type Value = T;
    type Error = Error;
    const HAS_RUNS: bool = K::HAS_RUNS;

    fn size(&self) -> [u32; 2] {
        self.size
    }

    /// O(log n) for n vertices, if the pixel's tile is held.
    ///
    /// # Errors
    ///
    /// As [`CachedMap::tile`]; [`Error::NoSuchPixel`] if the pixel lies outside.
    #[inline(always)]
    fn evaluate(&self, [x, y]: [u32; 2], depth: f32) -> Result<T> {
        if x >= self.size[0] || y >= self.size[1] {
            return Err(Self::outside([x, y]));
        }
        let ((column, x), (row, y)) = (self.columns.split(x), self.rows.split(y));
        self.with_tile([column, row], |pixels| {
            let value = pixels.map_or(T::CLEAR, |pixels| {
                let pixel = y as usize * pixels.size()[0] as usize + x as usize;
                K::evaluate(K::view(pixels), pixel, depth)
            });
            (value, 1)
        })
    }

    /// As [`Self::evaluate`]; finds a tile that holds the whole block once.
    #[inline(always)]
    fn evaluate_block(&self, visitor: &mut impl BlockVisitor<T>) -> Result<()> {
        let [columns, rows] = visitor.bounds();
        if columns.is_empty() || rows.is_empty() {
            return Ok(());
        }
        if columns.end > self.size[0] || rows.end > self.size[1] {
            return Err(Self::outside([columns.end - 1, rows.end - 1]));
        }
        let ((tile_column, x), (tile_row, y)) =
            (self.columns.split(columns.start), self.rows.split(rows.start));
        let tile = [tile_column, tile_row];
        let is_whole = columns.len() as u32 <= self.columns.size - x
            && rows.len() as u32 <= self.rows.size - y;
        let index = self.slot_of(tile);
        let slot = &self.slots[index];
        let held = slot.replace(Slot::VACANT);
        let start = [columns.start, rows.start];
        let step = Step::between(self.last.replace(start), start);
        if !is_whole || held.tile != tile {
            slot.set(held);
            return self.evaluate_pieces([columns, rows], step, visitor);
        }
        let corner = [columns.start - x, rows.start - y];
        self.rows_ahead[index].include::<K, T>(&rows, step, corner[1], held.tile());
        let asked = evaluate_block::<K, T>(&held, corner, &columns, rows, visitor);
        slot.set(held);
        self.hits.update(|hits| hits + asked);
        Ok(())
    }
}

impl<T: Transmittance, K: FieldKind> LookupCursor<T, K> {
    /// As [`Self::evaluate_block`], for blocks over several tiles or over
    /// one that is not held: what lies in up to 2 × 2 tiles that are held
    /// costs as many looks at the slots, and the rest one a row and tile.
    #[inline(always)]
    fn evaluate_pieces(
        &self,
        [columns, rows]: [Range<u32>; 2],
        step: Step,
        visitor: &mut impl BlockVisitor<T>,
    ) -> Result<()> {
        let mut row = rows.start;
        while row < rows.end {
            let done = self.evaluate_held([&columns, &(row..rows.end)], step, visitor);
            if done == 0 {
                self.evaluate_row(&columns, row, visitor)?;
            }
            row += done.max(1);
        }
        Ok(())
    }

    /// The rows at the top of a block that lie in one row of tiles, if the
    /// block is over at most two in a row, and both are held. Tells how many
    /// rows that is, or 0.
    #[inline(always)]
    fn evaluate_held(
        &self,
        [columns, rows]: [&Range<u32>; 2],
        step: Step,
        visitor: &mut impl BlockVisitor<T>,
    ) -> u32 {
        let ((column, x), (row, y)) =
            (self.columns.split(columns.start), self.rows.split(rows.start));
        let [left, top] = [columns.start - x, rows.start - y];
        let (last_column, _) = self.columns.split(columns.end - 1);
        if last_column - column > 1 {
            return 0;
        }
        let rows = rows.start..rows.end.min(top + self.rows.size);
        let tiles = [[column, row], [last_column, row]];
        let slots = tiles.map(|tile| &self.slots[self.slot_of(tile)]);
        let first = slots[0].replace(Slot::VACANT);
        // Of one tile, there is no second.
        let second = slots[1].replace(Slot::VACANT);
        let count = 1 + (last_column - column) as usize;
        let mut done = 0;
        if first.tile == tiles[0] && (count == 1 || second.tile == tiles[1]) {
            for (tile, held) in tiles.into_iter().zip([&first, &second]).take(count) {
                let ahead = &self.rows_ahead[self.slot_of(tile)];
                ahead.include::<K, T>(&rows, step, top, held.tile());
            }
            let mut asked = 0;
            for row in rows.clone() {
                let run = within(columns, visitor.columns(row));
                let mut edge = left;
                for held in [&first, &second].into_iter().take(count) {
                    let piece = within(&(edge..edge + self.columns.size), run.clone());
                    asked += evaluate_run::<K, T>(held, [edge, top], row, piece, visitor);
                    edge += self.columns.size;
                }
            }
            self.hits.update(|hits| hits + asked);
            done = rows.len() as u32;
        }
        slots[1].set(second);
        slots[0].set(first);
        done
    }

    /// As [`Self::evaluate_block`], for one row of a block over any number of
    /// tiles, which are fetched if they are not held.
    #[inline(always)]
    fn evaluate_row(
        &self,
        columns: &Range<u32>,
        row: u32,
        visitor: &mut impl BlockVisitor<T>,
    ) -> Result<()> {
        let (tile_row, y) = self.rows.split(row);
        let Range { start: mut column, end } = within(columns, visitor.columns(row));
        while column < end {
            // No tile is fetched for pixels that are passed over.
            let Some(depth) = visitor.depth(column) else {
                column += 1;
                continue;
            };
            let (tile_column, x) = self.columns.split(column);
            let rest = column + 1..end.min(column - x + self.columns.size);
            column = rest.end;
            self.with_tile([tile_column, tile_row], |pixels| match pixels {
                None => {
                    visitor.take(T::CLEAR);
                    ((), 1 + take_clear(rest, visitor))
                }
                Some(pixels) => {
                    let first = y as usize * pixels.size()[0] as usize + x as usize;
                    let view = K::view(pixels);
                    visitor.take(K::evaluate(view, first, depth));
                    ((), 1 + K::evaluate_run(view, rest, first + 1, visitor))
                }
            })?;
        }
        Ok(())
    }
}

impl<T: Transmittance, K: MapKind> fmt::Debug for LookupCursor<T, K> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { level, size, hits, .. } = self;
        f.debug_struct("LookupCursor")
            .field("level", level)
            .field("size", size)
            .field("hits", hits)
            .finish_non_exhaustive()
    }
}

impl<T: Transmittance, K: MapKind> Drop for LookupCursor<T, K> {
    fn drop(&mut self) {
        self.map.hand_in(&self.hits);
    }
}

/// The logarithm of the slots in a line, for a level's columns of tiles.
fn slot_columns(tiles: u32) -> u32 {
    tiles.max(1).next_power_of_two().ilog2().min(MOST_SLOT_COLUMNS)
}

#[inline(always)]
const fn slot_of([column, row]: [u32; 2], slot_columns: u32) -> usize {
    let column = column & ((1 << slot_columns) - 1);
    ((row << slot_columns | column) % SLOTS) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::achieved_error::AchievedError;
    use crate::cache::TileCache;
    use crate::limits::Limits;
    use crate::metadata::Metadata;
    use crate::reader::MapReader;
    use crate::write_options::WriteOptions;
    use crate::writer::write_map;
    use dsm_core::{DeepMap, MapInfo, PixelListsBuilder, Vertex};

    /// A map of tiles of 8 × 8 pixels, 8 in a row, behind a cache that keeps
    /// none.
    fn tiled(height: u32) -> (DeepMap<f32>, TileCache, CachedMap<f32>) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("map.dsm");
        let mut pixels = PixelListsBuilder::<f32>::new(64, height);
        for pixel in 0..64 * height {
            pixels.push(Vertex::new(1.0, 1.0));
            pixels.push(Vertex::new(2.0, pixel as f32 / 16_384.0));
            pixels.finish_pixel().unwrap();
        }
        let map = DeepMap::new(MapInfo::default(), pixels.finish().unwrap());
        let metadata = Metadata::new(64, height, 1, MapInfo::default());
        let options = WriteOptions::default().with_tile_size(8);
        write_map(&path, metadata, &map, AchievedError::NONE, options).unwrap();
        let reader = MapReader::open_in_memory(&path, &Limits::default()).unwrap();
        let cache = TileCache::new(0);
        let cached = cache.insert(reader).unwrap();
        (map, cache, cached)
    }

    #[test]
    fn all_tiles_of_a_level_of_256_are_held() {
        let (map, cache, cached) = tiled(256);
        let cursor = cached.cursor();
        for _ in 0..2 {
            for tile in 0..256 {
                let pixel = [tile % 8 * 8, tile / 8 * 8];
                assert_eq!(cursor.evaluate(pixel, 2.0).ok(), map.evaluate(pixel, 2.0).ok());
            }
        }
        let statistics = cache.statistics();
        assert_eq!((statistics.loads, statistics.pinned_tiles), (256, 256));
    }

    #[test]
    fn held_tiles_keep_within_their_bytes() {
        let (map, cache, cached) = tiled(8);
        let tile = cached.tile(TileId::new(0, 0, 0)).unwrap().unwrap().bytes();
        for (held, tiles) in [(8 * tile, 8), (3 * tile, 3), (tile, 1), (0, 1)] {
            let mut cursor = cached.cursor();
            cursor.most_held_bytes = held;
            let mut most = 0;
            for step in 0..1000_u32 {
                let [x, y] = [step * 37 % 64, step * 11 % 8];
                let in_memory = map.pixel(x, y).at(2.0);
                assert_eq!(cursor.evaluate([x, y], 2.0).unwrap(), in_memory);
                most = most.max(cache.statistics().pinned_bytes / tile);
            }
            assert_eq!(most, tiles, "{held} bytes");
            cursor.release();
            assert_eq!((cursor.held_bytes.get(), cache.statistics().pinned_bytes), (0, 0));
        }
    }

    #[test]
    fn tiles_of_a_footprint_do_not_share_a_slot() {
        for (tiles, line) in [(1, 1), (2, 2), (5, 8), (8, 8), (16, 16), (1 << 31, 16)] {
            let columns = slot_columns(tiles);
            let tile = |i: u32| [1_000_000 + i % line, 77_777 + i / line];
            let mut slots: Vec<_> = (0..SLOTS).map(|i| slot_of(tile(i), columns)).collect();
            slots.sort_unstable();
            assert!(slots.into_iter().eq(0..SLOTS as usize), "{tiles} columns");
        }
    }
}
