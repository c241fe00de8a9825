//! A map of 16384 × 16384 pixels, nearly all of them empty: written, given a
//! pyramid, cut anew and read back within a bounded memory, and in a time that
//! goes by what is in it. A program of its own, so that the peak is its own:
//! `cargo test --release -p dsm-tests --test huge_map -- --ignored --nocapture`

#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::path::Path;
use std::time::Instant;

use dsm_core::detail::PixelLists;
use dsm_core::{MapInfo, PixelListsBuilder, Progress, Tolerance, Vertex};
use dsm_io::detail::{MapWriter, TileId};
use dsm_io::{
    AchievedError, ConvertOptions, Limits, MapReader, MapSource, Metadata, Packing, PyramidOptions,
    WriteOptions, convert, mip,
};

const SIZE: u32 = 16_384;
const TILE: u32 = 64;
const MOST_MEMORY: u64 = 512 << 20;

/// The process's peak resident memory so far, in bytes.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok()? << 10)
}

/// A number below 2³² that the three determine.
fn mixed(x: u32, y: u32, salt: u32) -> u32 {
    let mut bits = x.wrapping_mul(0x9e37_79b9) ^ y.wrapping_mul(0x85eb_ca6b) ^ salt;
    for _ in 0..3 {
        bits = (bits ^ bits >> 15).wrapping_mul(0x2c1b_3c6d);
        bits = (bits ^ bits >> 12).wrapping_mul(0x297a_2d39);
    }
    bits ^ bits >> 15
}

/// One tile in a hundred.
fn is_occupied(x: u32, y: u32) -> bool {
    mixed(x, y, 1).is_multiple_of(100)
}

/// Hair: in every pixel some sheets that each stop an eighth.
fn tile(x: u32, y: u32) -> PixelLists<f32> {
    let mut pixels = PixelListsBuilder::new(TILE, TILE);
    for (row, column) in (0..TILE).flat_map(|row| (0..TILE).map(move |column| (row, column))) {
        let (px, py) = (x * TILE + column, y * TILE + row);
        let (mut z, mut value) = (1.0 + (mixed(px, py, 2) % 1000) as f32 * 0.01, 1.0_f32);
        for sheet in 0..mixed(px, py, 3) % 6 {
            pixels.push(Vertex::new(z, value));
            value *= 0.875;
            pixels.push(Vertex::new(z, value));
            z += 0.125 + (mixed(px, py, 4 + sheet) % 1000) as f32 * 0.001;
        }
        pixels.finish_pixel().unwrap();
    }
    pixels.finish().unwrap()
}

fn write(path: &Path) -> u64 {
    let info = MapInfo::new().with_tolerance(Tolerance::new(0.02).unwrap());
    let options = WriteOptions::default().with_tile_size(TILE).with_packing(Packing::Zstd);
    let metadata = Metadata::new(SIZE, SIZE, 1, info);
    let mut writer = MapWriter::create(path, metadata, options).unwrap();
    let tiles = SIZE / TILE;
    let mut written = 0;
    for (y, x) in (0..tiles).flat_map(|y| (0..tiles).map(move |x| (y, x))) {
        if is_occupied(x, y) {
            let id = TileId::new(0, x, y);
            writer.write_tile(id, tile(x, y).view(), AchievedError::NONE).unwrap();
            written += 1;
        }
    }
    writer.finish().unwrap();
    written
}

/// What is blocked for good, as a share of the level; and how many tiles have
/// vertices.
fn blocked(reader: &MapReader, index: u32) -> (f64, u64) {
    let level = reader.levels()[index as usize];
    let (mut blocked, mut occupied) = (0.0, 0);
    for (id, entry) in reader.directory(index).unwrap().iter() {
        let tile = reader.tile::<f32>(id).unwrap();
        occupied += u64::from(!entry.is_empty());
        let functions = tile.view().functions();
        blocked += functions.map(|function| 1.0 - f64::from(function.last())).sum::<f64>();
    }
    (blocked / level.pixel_count() as f64, occupied)
}

fn open(path: &Path) -> MapReader {
    MapReader::open(path, &Limits::default()).unwrap()
}

#[test]
#[ignore = "takes seconds, and measures the memory of its own process"]
fn a_huge_empty_map_takes_little_memory_and_time() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("huge.dsm");
    let clock = Instant::now();
    let tell = |what: &str| {
        let peak = peak_memory().map_or(0, |bytes| bytes >> 20);
        eprintln!("{:>6.2} s, {peak:>4} MiB at most: {what}", clock.elapsed().as_secs_f64());
    };
    let written = write(&path);
    assert!((500..800).contains(&written), "{written}");
    tell("written");

    let mut tiles = (0, 0);
    mip(&open(&path), &path, &PyramidOptions::default(), |tile| {
        tiles = (tile.done, tile.total);
        Progress::ignore(tile)
    })
    .unwrap();
    assert_eq!(tiles, (written, written));
    tell("mip-mapped");

    let reader = open(&path);
    assert_eq!(reader.levels().len(), 15);
    let (whole, occupied) = blocked(&reader, 0);
    assert_eq!(occupied, written);
    assert!(whole > 1e-3, "{whole}");
    for index in 1..15 {
        let (level, error) = (blocked(&reader, index).0, reader.levels()[index as usize].error);
        // Last values are exact but for their rounding.
        assert!((level - whole).abs() < 1e-7, "level {index}: {level}, not {whole}");
        assert!(0.0 < error.max && error.max <= reader.levels()[index as usize].tolerance);
    }
    tell("read back");
    assert!(reader.verify().is_empty());
    tell("verified");

    let copy = folder.path().join("copy.dsm");
    let options = ConvertOptions::default();
    let options = ConvertOptions {
        write: options.write.with_tile_size(256).with_packing(Packing::Zstd),
        ..options
    };
    let mut source = MapSource::open(&path, None, &Limits::default()).unwrap();
    convert(&mut source, &copy, &options, Progress::ignore).unwrap();
    assert!((blocked(&open(&copy), 0).0 - whole).abs() < 1e-12);
    tell("cut into larger tiles");

    if let Some(peak) = peak_memory() {
        assert!(peak < MOST_MEMORY, "{peak} bytes");
    }
}
