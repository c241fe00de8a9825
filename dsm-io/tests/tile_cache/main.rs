//! Lookups through a tile cache: the values of the map in memory, whatever
//! the budget and however many threads ask.

#![expect(clippy::unwrap_used, reason = "helpers of tests stop where a value is refused")]

mod levels;
mod maps;

use std::borrow::Cow;
use std::fmt::Debug;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use dsm_core::detail::{BlockVisitor, InFile};
use dsm_core::{Rgb, Transmittance, VisibilityField};
use dsm_io::detail::{Container, LookupCursor, Memory, Source, TileCache, TileId};
use dsm_io::{Error, Limits, MapReader, Packing};

use maps::{SIZE, THREADS, TILE, compare, map, tiles_with_pixels, write, written};

fn agrees_under_threads<T: Transmittance>(packing: Packing, lookups: u32) {
    let (map, reader) = written::<T>(1, packing);
    let largest = (0..SIZE[0].div_ceil(TILE))
        .flat_map(|x| (0..SIZE[1].div_ceil(TILE)).map(move |y| TileId::new(0, x, y)))
        .map(|id| reader.directory(0).unwrap().get(id.x, id.y).unwrap().raw_length)
        .max();
    let cache = TileCache::new(2 * largest.unwrap());
    let cached = cache.insert::<T, _>(reader).unwrap();
    let pixels: u64 = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..THREADS)
            .map(|thread| {
                let (map, cached) = (&map, &cached);
                scope.spawn(move || compare(map, &cached.cursor(), thread, lookups))
            })
            .collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).sum()
    });
    let statistics = cache.statistics();
    assert_eq!(statistics.hits + statistics.misses, pixels);
    assert!(statistics.bytes <= cache.budget() && statistics.tiles >= 2, "{statistics:?}");
    assert!(statistics.evictions > tiles_with_pixels(cached.reader()), "{statistics:?}");
    assert!(statistics.peak_bytes > cache.budget(), "the cursors hold more");
    assert!(statistics.loads <= statistics.misses && statistics.failed_loads == 0);
    assert_eq!((statistics.pinned_tiles, statistics.pinned_bytes), (0, 0), "all cursors are gone");
}

#[test]
fn a_million_lookups_by_eight_threads_equal_the_map_in_memory() {
    agrees_under_threads::<f32>(Packing::Plain, 125_000);
}

#[test]
fn colours_and_packed_tiles_equal_the_map_in_memory() {
    agrees_under_threads::<Rgb>(Packing::Zstd, 5_000);
}

#[test]
fn a_tile_that_stays_is_loaded_once() {
    let (map, reader) = written::<f32>(2, Packing::Zstd);
    let count = tiles_with_pixels(&reader);
    assert_eq!(count, u64::from(SIZE[0].div_ceil(TILE) * SIZE[1].div_ceil(TILE)) - 6);
    let cache = TileCache::new(u64::MAX);
    let cached = cache.insert::<f32, _>(reader).unwrap();
    std::thread::scope(|scope| {
        for _ in 0..THREADS {
            scope.spawn(|| {
                let cursor = cached.cursor();
                for pixel in 0..SIZE[0] * SIZE[1] {
                    let pixel = [pixel % SIZE[0], pixel / SIZE[0]];
                    let Ok(expected) = map.evaluate(pixel, 1.0);
                    assert_eq!(cursor.evaluate(pixel, 1.0).unwrap(), expected);
                }
            });
        }
    });
    let statistics = cache.statistics();
    assert_eq!((statistics.loads, statistics.tiles, statistics.evictions), (count, count, 0));
    assert_eq!(statistics.hits + statistics.misses, THREADS * u64::from(SIZE[0] * SIZE[1]));
    assert_eq!(statistics.peak_bytes, statistics.bytes);
}

#[test]
fn empty_tiles_are_not_loaded() {
    let (_, reader) = written::<f32>(3, Packing::Plain);
    let cache = TileCache::new(1 << 20);
    let cached = cache.insert::<f32, _>(reader).unwrap();
    assert!(cached.tile(TileId::new(0, 2, 1)).unwrap().is_none());
    assert_eq!(cached.cursor().evaluate([5, 5], 3.0).unwrap(), 1.0);
    let statistics = cache.statistics();
    assert_eq!((statistics.hits, statistics.misses, statistics.peak_bytes), (2, 0, 0));
}

#[test]
fn tiles_over_the_budget_are_shared_by_cursors() {
    let (map, reader) = written::<f32>(4, Packing::Plain);
    let cache = TileCache::new(0);
    let cached = cache.insert::<f32, _>(reader).unwrap();
    let (pixel, [first, second]) = ([80, 50], [cached.cursor(), cached.cursor()]);
    let Ok(expected) = map.evaluate(pixel, 2.0);
    for cursor in [&first, &first, &second] {
        assert_eq!(cursor.evaluate(pixel, 2.0).unwrap(), expected);
    }
    let tile = cached.tile(TileId::new(0, 80 / TILE, 50 / TILE)).unwrap().unwrap();
    let statistics = cache.statistics();
    assert_eq!((statistics.loads, statistics.tiles, statistics.bytes), (1, 0, 0));
    assert_eq!((statistics.pinned_tiles, statistics.pinned_bytes), (1, tile.bytes()));
    first.release();
    drop((second, tile));
    assert_eq!(cache.statistics().pinned_bytes, 0);
    assert_eq!(first.evaluate(pixel, 2.0).unwrap(), expected);
    assert_eq!(
        (cache.statistics().loads, cache.statistics().peak_bytes),
        (2, statistics.pinned_bytes)
    );
}

#[test]
fn several_files_share_a_cache() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let (key, rim, coloured) = (map::<f32>(5), map::<f32>(6), map::<Rgb>(7));
    write(&path("key.dsm"), &key, Packing::Plain);
    write(&path("rim.dsm"), &rim, Packing::Zstd);
    write(&path("coloured.dsm"), &coloured, Packing::Plain);
    let (cache, limits) = (TileCache::new(u64::MAX), Limits::default());
    let open = |name: &str| cache.open::<f32>(path(name), &limits).unwrap();
    let (cached_key, cached_rim) = (open("key.dsm"), open("rim.dsm"));
    let cached_coloured = cache.clone().open::<Rgb>(path("coloured.dsm"), &limits).unwrap();
    let cursors = (cached_key.cursor(), cached_rim.cursor(), cached_coloured.cursor());
    compare(&key, &cursors.0, 1, 10_000);
    compare(&rim, &cursors.1, 1, 10_000);
    compare(&coloured, &cursors.2, 1, 10_000);
    let of_coloured = |id| cached_coloured.tile(id).unwrap().map_or(0, |tile| tile.bytes());
    let ids = cached_coloured.reader().directory(0).unwrap().iter().map(|(id, _)| id);
    let bytes: u64 = ids.map(of_coloured).sum();
    let before = cache.statistics();
    drop((cursors.2, cached_coloured));
    let after = cache.statistics();
    assert_eq!(after.bytes, before.bytes - bytes, "a closed map takes its tiles with it");
    assert_eq!((after.pinned_bytes, after.evictions), (0, 0));
    compare(&key, &cursors.0, 2, 1_000);
    assert!(matches!(
        cache.open::<Rgb>(path("key.dsm"), &limits),
        Err(Error::Channels { channels: 1, asked: 3 })
    ));
}

/// A file that can be repaired.
#[derive(Debug)]
struct Repairable {
    damaged: Memory,
    whole: Memory,
    is_repaired: Arc<AtomicBool>,
}

impl Source for Repairable {
    fn length(&self) -> u64 {
        self.whole.length()
    }

    fn read(&self, range: Range<u64>) -> dsm_io::detail::Result<Cow<'_, [u8]>> {
        let repaired = self.is_repaired.load(Ordering::SeqCst);
        if repaired { self.whole.read(range) } else { self.damaged.read(range) }
    }
}

#[test]
fn a_damaged_tile_is_an_error_until_it_can_be_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    let map = map::<f32>(8);
    write(&path, &map, Packing::Plain);
    let whole = std::fs::read(&path).unwrap();
    let reader = MapReader::from_bytes(whole.clone(), &Limits::default()).unwrap();
    let id = TileId::new(0, 5, 5);
    let mut damaged = whole.clone();
    damaged[reader.directory(0).unwrap().get(id.x, id.y).unwrap().offset as usize + 7] ^= 1;
    let is_repaired = Arc::new(AtomicBool::new(false));
    let source = Repairable {
        damaged: damaged.into(),
        whole: whole.into(),
        is_repaired: Arc::clone(&is_repaired),
    };
    let limits = Limits::default();
    let container = Container::from_source(source, &limits).unwrap();
    let cache = TileCache::new(1 << 20);
    let cached = cache.insert::<f32, _>(MapReader::new(container, &limits).unwrap()).unwrap();
    let (cursor, pixel) = (cached.cursor(), [5 * TILE + 1, 5 * TILE]);
    let direct = cached.reader().tile::<f32>(id).unwrap_err();
    std::thread::scope(|scope| {
        for _ in 0..THREADS {
            scope.spawn(|| {
                let error = cached.cursor().evaluate(pixel, 1.0).unwrap_err();
                assert_eq!(error.to_string(), direct.to_string());
                assert!(
                    matches!(&error, Error::Shared(error) if matches!(**error, Error::Checksum { .. }))
                );
            });
        }
    });
    assert!(cursor.evaluate(pixel, 1.0).is_err());
    let failed = cache.statistics();
    assert_eq!((failed.hits, failed.misses, failed.loads), (0, THREADS + 1, 0));
    // Its neighbour is whole.
    assert!(cursor.evaluate([pixel[0], pixel[1] - 1], 1.0).is_ok());
    is_repaired.store(true, Ordering::SeqCst);
    let Ok(expected) = map.evaluate(pixel, 1.0);
    assert_eq!(cursor.evaluate(pixel, 1.0).unwrap(), expected);
    assert_eq!(cache.statistics().failed_loads, failed.failed_loads);
}

#[test]
fn what_is_not_there_is_an_error() {
    let (_, reader) = written::<f32>(9, Packing::Plain);
    let cached = TileCache::new(1 << 20).insert::<f32, _>(reader).unwrap();
    assert!(matches!(cached.level_cursor(1), Err(Error::NoSuchLevel(1))));
    let error = cached.tile(TileId::new(0, 99, 0)).unwrap_err();
    assert!(matches!(
        error,
        Error::File(InFile { error, .. }) if matches!(*error, Error::NoSuchTile(TileId { x: 99, .. }))
    ));
    let cursor = cached.level_cursor(0).unwrap();
    assert_eq!((cursor.size(), cursor.level()), (SIZE, 0));
    for pixel in [[SIZE[0], 0], [0, SIZE[1]], [u32::MAX; 2]] {
        assert!(matches!(cursor.evaluate(pixel, 1.0), Err(Error::NoSuchPixel(_))), "{pixel:?}");
    }
}

/// Asks for the diagonal of a square, and its own cursor for the first pixel
/// of each row meanwhile.
struct Diagonal<'a> {
    cursor: &'a LookupCursor<f32>,
    bounds: [Range<u32>; 2],
    row: u32,
    taken: Vec<f32>,
}

impl BlockVisitor<f32> for Diagonal<'_> {
    fn bounds(&self) -> [Range<u32>; 2] {
        self.bounds.clone()
    }

    fn columns(&mut self, row: u32) -> Range<u32> {
        self.row = row;
        // Wider than the bounds.
        0..u32::MAX
    }

    fn depth(&mut self, column: u32) -> Option<f32> {
        let [columns, rows] = &self.bounds;
        assert!(columns.contains(&column));
        (column - columns.start == self.row - rows.start).then_some(2.0)
    }

    fn take(&mut self, value: f32) {
        self.taken.push(value);
        let [columns, rows] = &self.bounds;
        self.cursor.evaluate([columns.start, rows.start], 1.0).unwrap();
    }
}

#[test]
fn a_block_fetches_only_tiles_that_it_asks() {
    let (map, reader) = written::<f32>(12, Packing::Plain);
    let cache = TileCache::new(1 << 20);
    let cursor = cache.insert::<f32, _>(reader).unwrap().cursor();
    // Over 2 × 2 tiles, of which the diagonal meets 2; then within one of
    // those, which is held.
    for (start, end) in [(59, 67), (54, 60)] {
        let bounds = [start..end, start..end];
        let mut diagonal = Diagonal { cursor: &cursor, bounds, row: 0, taken: vec![] };
        cursor.evaluate_block(&mut diagonal).unwrap();
        let expected: Result<Vec<_>, _> = (start..end).map(|i| map.evaluate([i, i], 2.0)).collect();
        assert_eq!(Ok(diagonal.taken), expected);
        cursor.release();
        assert_eq!(cache.statistics().loads, 2);
        assert!(cursor.evaluate([start, start], 1.0).is_ok());
    }
    let statistics = cache.statistics();
    assert_eq!((statistics.misses, statistics.hits), (2, 2 * (8 + 6) + 2 - 2));
    let bounds = [SIZE[0] - 1..SIZE[0] + 1, 0..1];
    let mut outside = Diagonal { cursor: &cursor, bounds, row: 0, taken: vec![] };
    assert!(matches!(cursor.evaluate_block(&mut outside), Err(Error::NoSuchPixel(_))));
    assert!(outside.taken.is_empty());
}
