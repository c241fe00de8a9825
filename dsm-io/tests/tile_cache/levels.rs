//! Lookups over the levels of a map.

use dsm_core::detail::Pyramid;
use dsm_core::{
    DeepMap, Filter, FilterShape, Footprint, LevelChoice, MapInfo, PixelListsBuilder, Receiver,
    Rgb, Transmittance, VisibilityField,
};
use dsm_io::detail::{Level, MapWriter, TileCache, TileId};
use dsm_io::{AchievedError, Limits, Metadata, WriteOptions};

use crate::maps::{Random, SIZE, TILE, bits, map};

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
