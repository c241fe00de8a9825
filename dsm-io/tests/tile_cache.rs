//! Lookups through a tile cache: the values of the map in memory, whatever
//! the budget and however many threads ask.

#![expect(clippy::unwrap_used, reason = "helpers of tests stop where a value is refused")]

use std::borrow::Cow;
use std::cell::Cell;
use std::fmt::Debug;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use dsm_core::detail::{BlockVisitor, InFile, Pyramid};
use dsm_core::{
    DeepMap, Filter, FilterShape, Footprint, LevelChoice, MapInfo, PixelListsBuilder, Receiver,
    Rgb, Transmittance, Vertex, VisibilityField, filtered_lookup,
};
use dsm_io::detail::{
    Container, Level, LookupCursor, MapWriter, Memory, Source, TileCache, TileId,
};
use dsm_io::{AchievedError, Error, Limits, MapReader, Metadata, Packing, WriteOptions, write_map};

const SIZE: [u32; 2] = [150, 100];
const TILE: u32 = 9;
const THREADS: u64 = 8;

/// A stream of numbers in [0, 1).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }
}

/// Steps and ramps of 0 to 4 falls a pixel; the tiles of one corner are
/// empty.
fn map<T: Transmittance>(seed: u64) -> DeepMap<T> {
    let mut random = Random(seed);
    let mut pixels = PixelListsBuilder::new(SIZE[0], SIZE[1]);
    for y in 0..SIZE[1] {
        for x in 0..SIZE[0] {
            let falls = if x < 3 * TILE && y < 2 * TILE { 0 } else { (random.next() * 5.0) as u32 };
            let (mut z, mut value) = (random.next(), T::CLEAR);
            for _ in 0..falls {
                pixels.push(Vertex::new(z, value));
                z += if random.next() < 0.5 { 0.0 } else { random.next() };
                value = T::from_channels(|channel| value.channel(channel) * random.next());
                pixels.push(Vertex::new(z, value));
                z += 0.1;
            }
            pixels.finish_pixel().unwrap();
        }
    }
    DeepMap::new(MapInfo::default(), pixels.finish().unwrap())
}

fn write<T: Transmittance>(path: &Path, map: &DeepMap<T>, packing: Packing) {
    let metadata = Metadata::new(SIZE[0], SIZE[1], T::CHANNELS as u8, *map.info());
    let options = WriteOptions::default().with_tile_size(TILE).with_packing(packing);
    write_map(path, metadata, map, AchievedError::NONE, options).unwrap();
}

/// A map, and a reader of it.
fn written<T: Transmittance>(seed: u64, packing: Packing) -> (DeepMap<T>, MapReader) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    let map = map(seed);
    write(&path, &map, packing);
    (map, MapReader::open_in_memory(&path, &Limits::default()).unwrap())
}

fn tiles_with_pixels(reader: &MapReader) -> u64 {
    let entries = reader.directory(0).unwrap().iter();
    entries.filter(|(_, entry)| !entry.is_empty()).count() as u64
}

/// A field that counts what it is asked.
struct Counted<'a, F>(&'a F, Cell<u64>);

impl<F: VisibilityField> VisibilityField for Counted<'_, F> {
    type Value = F::Value;
    type Error = F::Error;

    fn size(&self) -> [u32; 2] {
        self.0.size()
    }

    fn evaluate(&self, pixel: [u32; 2], depth: f32) -> Result<F::Value, F::Error> {
        self.1.set(self.1.get() + 1);
        self.0.evaluate(pixel, depth)
    }

    fn evaluate_block(&self, visitor: &mut impl BlockVisitor<F::Value>) -> Result<(), F::Error> {
        self.0.evaluate_block(&mut CountedBlock(visitor, &self.1))
    }
}

/// A visitor that counts what it asks.
struct CountedBlock<'a, V>(&'a mut V, &'a Cell<u64>);

impl<T, V: BlockVisitor<T>> BlockVisitor<T> for CountedBlock<'_, V> {
    fn bounds(&self) -> [Range<u32>; 2] {
        self.0.bounds()
    }

    fn columns(&mut self, row: u32) -> Range<u32> {
        self.0.columns(row)
    }

    fn depth(&mut self, column: u32) -> Option<f32> {
        let depth = self.0.depth(column);
        self.1.set(self.1.get() + u64::from(depth.is_some()));
        depth
    }

    fn take(&mut self, value: T) {
        self.0.take(value);
    }
}

fn bits<T: Transmittance>(value: T) -> Vec<u32> {
    (0..T::CHANNELS).map(|channel| value.channel(channel).to_bits()).collect()
}

/// Compares `lookups` filtered lookups that wander, and at times jump; tells
/// how many pixels they asked for.
fn compare<T: Transmittance, F: VisibilityField<Value = T>>(
    map: &DeepMap<T>,
    field: &F,
    seed: u64,
    lookups: u32,
) -> u64
where
    F::Error: Debug,
{
    let field = Counted(field, Cell::new(0));
    let filter = |shape, width| Footprint::Isotropic(Filter::new(shape, width).unwrap());
    let slanted =
        Footprint::Elliptical { shape: FilterShape::Gaussian, axes: [[9.0, 6.0], [-1.0, 1.5]] };
    let (narrow, tent) = (filter(FilterShape::Box, 3.0), filter(FilterShape::Tent, 4.0));
    let footprints = [Footprint::Point, narrow, Footprint::Point, narrow, slanted, tent];
    let mut random = Random(seed);
    let size = SIZE.map(|size| size as f32);
    let mut at = [0.0; 2];
    for lookup in 0..lookups {
        if lookup % 100 == 0 {
            at = size.map(|size| random.next() * size);
        }
        at =
            [0, 1].map(|axis| (at[axis] + 4.0 * random.next() - 2.0).clamp(0.0, size[axis] - 0.01));
        let receiver = Receiver::new(at, 4.0 * random.next());
        let footprint = footprints[lookup as usize % 6];
        let Ok(expected) = filtered_lookup(map, &receiver, &footprint);
        let found = filtered_lookup(&field, &receiver, &footprint).unwrap();
        assert_eq!(bits(found), bits(expected), "{receiver:?}");
    }
    field.1.get()
}

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

/// The pixels of level `k` from those of level 0: the first of each square.
fn thinned<T: Transmittance>(map: &DeepMap<T>, k: u32) -> DeepMap<T> {
    let [width, height] = SIZE.map(|side| side.div_ceil(1 << k));
    let mut pixels = PixelListsBuilder::new(width, height);
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
        map.pixel(x << k, y << k).vertices().for_each(|vertex| pixels.push(vertex));
        pixels.finish_pixel().unwrap();
    }
    DeepMap::new(*map.info(), pixels.finish().unwrap())
}

/// Cuts a level into tiles.
fn write_level<T: Transmittance>(writer: &mut MapWriter, index: u32, map: &DeepMap<T>) {
    let level = writer.levels()[index as usize];
    let [columns, rows] = level.tiles();
    for (y, x) in (0..rows).flat_map(|y| (0..columns).map(move |x| (y, x))) {
        let rect = level.tile_rect(x, y).unwrap();
        let mut tile = PixelListsBuilder::<T>::new(rect.width, rect.height);
        for (row, column) in (0..rect.height).flat_map(|y| (0..rect.width).map(move |x| (y, x))) {
            let pixel = map.pixel(rect.x + column, rect.y + row);
            pixel.vertices().for_each(|vertex| tile.push(vertex));
            tile.finish_pixel().unwrap();
        }
        let tile = tile.finish().unwrap();
        writer.write_tile(TileId::new(index, x, y), tile.view(), AchievedError::NONE).unwrap();
    }
}

fn levels_equal_the_map_in_memory<T: Transmittance>(lookups: u32) {
    let base = map::<T>(10);
    let levels: Vec<_> = (0..=8).map(|k| thinned(&base, k)).collect();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    let metadata = Metadata::new(SIZE[0], SIZE[1], T::CHANNELS as u8, *base.info());
    let options = WriteOptions::default().with_tile_size(TILE);
    let mut writer = MapWriter::create(&path, metadata, options).unwrap();
    for (level, number) in levels.iter().zip(0..) {
        if number > 0 {
            let [width, height] = level.size();
            writer.add_level(Level { number, ..Level::new(width, height, TILE, 0.0) }).unwrap();
        }
        write_level(&mut writer, number, level);
    }
    writer.finish().unwrap();
    let cached = TileCache::new(1 << 20).open::<T>(&path, &Limits::default()).unwrap();
    let (through_cache, in_memory) = (cached.pyramid().unwrap(), Pyramid::new(levels).unwrap());
    assert_eq!(through_cache.levels().len(), 9);
    let mut random = Random(11);
    for lookup in 0..lookups {
        let receiver = Receiver {
            depth_gradient: [random.next() * 0.1, random.next() * 0.1 - 0.05],
            ..Receiver::new(SIZE.map(|side| random.next() * side as f32), 4.0 * random.next())
        };
        let width = (random.next() * 8.0).exp2().max(2.0);
        let shape =
            [FilterShape::Box, FilterShape::Tent, FilterShape::Gaussian][lookup as usize % 3];
        let footprint = match lookup % 8 {
            0 => Footprint::Point,
            1 => Footprint::Elliptical { shape, axes: [[width, 0.5 * width], [-1.0, 2.0]] },
            _ => Footprint::Isotropic(Filter::new(shape, width).unwrap()),
        };
        let choice = match lookup % 5 {
            0 => LevelChoice::Fixed(f64::from(random.next() * 9.0).max(4.0)),
            _ => LevelChoice::Auto,
        };
        let Ok(expected) = in_memory.lookup(&receiver, &footprint, choice);
        let found = through_cache.lookup(&receiver, &footprint, choice).unwrap();
        assert_eq!(bits(found), bits(expected), "{receiver:?} {footprint:?} {choice:?}");
    }
}

#[test]
fn all_levels_equal_the_map_in_memory() {
    levels_equal_the_map_in_memory::<f32>(20_000);
    levels_equal_the_map_in_memory::<Rgb>(5_000);
}

#[test]
fn levels_that_are_no_pyramid_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    let metadata = Metadata::new(SIZE[0], SIZE[1], 1, MapInfo::default());
    let mut writer = MapWriter::create(&path, metadata, WriteOptions::default()).unwrap();
    writer.add_level(Level { number: 1, ..Level::new(74, 50, 64, 0.0) }).unwrap();
    writer.finish().unwrap();
    let cached = TileCache::new(0).open::<f32>(&path, &Limits::default()).unwrap();
    let refused = cached.pyramid().unwrap_err().to_string();
    assert!(refused.contains("map.dsm: level 1 of a pyramid: its size"), "{refused}");
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
