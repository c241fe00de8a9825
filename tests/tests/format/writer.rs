//! What the writer refuses, and what it fills in; what limits stop.

use std::borrow::Cow;
use std::ops::Range;

use dsm_core::detail::{InFile, PixelLists};
use dsm_core::{MapInfo, Rgb};
use dsm_io::detail::{
    Container, ContainerWriter, EncodedTile, Level, MapWriter, SectionKind, Source, Tile, TileId,
};
use dsm_io::{AchievedError, Error, Limits, MapReader, Metadata, Packing, WriteOptions};
use dsm_tests::forge::Forge;

use crate::examples::{coloured, document, mono};

fn bare_error(error: Error) -> Error {
    match error {
        Error::File(InFile { error, .. }) => *error,
        error => error,
    }
}

#[test]
fn wrong_tiles_are_refused_and_the_map_can_be_finished() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    let example = document();
    let mut writer = MapWriter::create(&path, example.metadata, example.options).unwrap();
    let (first, wide) = (PixelLists::<f32>::clear(2, 1), PixelLists::<f32>::clear(3, 1));
    let (none, id) = (AchievedError::NONE, TileId::new(0, 0, 0));
    let too_much = AchievedError { max: 0.07, mean: 0.01 };
    let disordered = AchievedError { max: 0.01, mean: 0.02 };

    let mut refused = |id, pixels: &PixelLists<f32>, error| {
        writer.write_tile(id, pixels.view(), error).unwrap_err().to_string()
    };
    assert!(refused(id, &wide, none).contains("has 2 × 1 pixels, not 3 × 1"));
    assert!(refused(TileId::new(0, 2, 0), &first, none).contains("there is no tile (2, 0)"));
    assert!(refused(TileId::new(1, 0, 0), &first, none).contains("there is no tile"));
    assert!(refused(id, &first, too_much).contains("more than the level's tolerance 0.0625"));
    assert!(refused(id, &first, disordered).contains("mean not above the largest"));
    let colour = PixelLists::<Rgb>::clear(2, 1);
    let refused = writer.write_tile(id, colour.view(), none);
    assert!(matches!(refused, Err(Error::Channels { channels: 1, asked: 3 })));

    writer.write_tile(id, first.view(), none).unwrap();
    let twice = writer.write_tile(id, first.view(), none);
    assert!(matches!(twice, Err(Error::WrittenTwice(_))));
    writer.finish().unwrap();
    let reader = MapReader::open(&path, &Limits::default()).unwrap();
    assert!(reader.directory(0).unwrap().iter().all(|(_, entry)| entry.is_empty()));
    assert!(reader.verify().is_empty());
    assert!(matches!(reader.read_map::<Rgb>(0), Err(Error::Channels { .. })));
}

#[test]
fn levels_and_views_come_in_order_and_keep_their_own_errors() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    let metadata = Metadata::new(5, 3, 1, MapInfo::default());
    let options = WriteOptions::default().with_tile_size(2);
    let mut writer = MapWriter::create(&path, metadata, options).unwrap();
    let half = Level { number: 1, x: -1, y: 7, ..Level::new(3, 2, 2, 0.25) };
    assert!(writer.add_level(Level { number: 2, ..half }).is_err());
    assert!(writer.add_level(Level { view: 2, number: 0, ..half }).is_err());
    assert!(writer.add_level(Level { width: 0, ..half }).is_err());
    assert_eq!(writer.add_level(half).unwrap(), 1);
    assert_eq!(writer.add_level(Level { view: 1, number: 0, ..half }).unwrap(), 2);
    // Two of level 1's tiles: 4 and 2 of its 6 pixels.
    for (x, width, error) in [(0, 2, 0.25), (1, 1, 0.0625)] {
        let pixels = PixelLists::<f32>::clear(width, 2);
        let error = AchievedError { max: error, mean: error * 0.5 };
        writer.write_tile(TileId::new(1, x, 0), pixels.view(), error).unwrap();
    }
    writer.finish().unwrap();

    let reader = MapReader::open(&path, &Limits::default()).unwrap();
    assert!(reader.verify().is_empty(), "{:?}", reader.verify());
    let level = reader.levels()[1];
    assert_eq!([level.x, level.y], [-1, 7]);
    assert_eq!(level.error.max, 0.25);
    assert_eq!(level.error.mean, (0.125 * 4.0 + 0.03125 * 2.0) / 6.0);
    assert_eq!(reader.levels()[2].view, 1);
    assert_eq!(reader.read_map::<f32>(1).unwrap().pixels().view().width(), 3);
    assert!(matches!(bare_error(reader.read_map::<f32>(3).unwrap_err()), Error::NoSuchLevel(3)));
}

#[test]
fn the_container_holds_any_kind_and_skips_what_it_need_not_know() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    let mut writer = ContainerWriter::create(&path).unwrap();
    writer.add_level(Level::new(4, 4, 4, 0.0)).unwrap();
    let tile = EncodedTile {
        bytes: b"whatever".to_vec(),
        raw_length: 8,
        codec: 77,
        ..EncodedTile::default()
    };
    let disordered = EncodedTile { z_min: 2.0, z_max: 1.0, ..tile.clone() };
    let no_bytes = EncodedTile { bytes: Vec::new(), ..tile.clone() };
    for wrong in [disordered, no_bytes] {
        let refused = writer.write_tile(TileId::default(), &wrong, AchievedError::NONE);
        assert!(matches!(refused, Err(Error::Tile { .. })), "{wrong:?}");
    }
    writer.write_tile(TileId::default(), &tile, AchievedError::NONE).unwrap();
    writer.write_section(SectionKind(*b"note"), b"of no importance").unwrap();
    writer.write_section(SectionKind(*b"none"), b"").unwrap();
    assert!(writer.write_section(SectionKind::METADATA, b"{}").is_err());
    writer.finish(br#"{"kind":"layers"}"#).unwrap();

    let container = Container::open(&path, &Limits::default()).unwrap();
    assert_eq!(container.kind().unwrap(), "layers");
    assert_eq!(container.payload(TileId::default()).unwrap(), b"whatever".as_slice());
    let kinds: Vec<_> = container.sections().map(|kind| kind.to_string()).collect();
    assert_eq!(kinds, ["note", "none", "META", "TDIR", "LEVL"]);
    assert_eq!(container.section(0).unwrap(), b"of no importance".as_slice());
    let refused = bare_error(MapReader::open(&path, &Limits::default()).unwrap_err());
    assert!(matches!(refused, Error::Kind { found, .. } if found == "layers"));
}

#[test]
fn verify_reads_what_readers_skip() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    let mut writer = ContainerWriter::create(&path).unwrap();
    writer.add_level(Level::new(1, 1, 1, 0.0)).unwrap();
    writer.write_section(SectionKind(*b"note"), b"of no importance").unwrap();
    let json = Metadata::new(1, 1, 1, MapInfo::default()).to_json().unwrap();
    writer.finish(&json).unwrap();
    let mut bytes = std::fs::read(&path).unwrap();
    let reader = MapReader::from_bytes(bytes.clone(), &Limits::default()).unwrap();
    assert!(reader.verify().is_empty());
    bytes[64] ^= 1;
    let reader = MapReader::from_bytes(bytes, &Limits::default()).unwrap();
    assert!(reader.read_map::<f32>(0).is_ok());
    let problems: Vec<_> = reader.verify().iter().map(ToString::to_string).collect();
    assert_eq!(problems.len(), 1);
    assert!(problems[0].starts_with("section 0 (note): checksum"), "{problems:?}");
}

#[test]
fn two_levels_cannot_share_a_directory() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    let metadata = Metadata::new(2, 1, 1, MapInfo::default());
    let mut writer = MapWriter::create(&path, metadata, WriteOptions::default()).unwrap();
    writer.add_level(Level { number: 1, ..Level::new(1, 1, 1, 0.0) }).unwrap();
    writer.finish().unwrap();
    let mut forge = Forge(std::fs::read(&path).unwrap());
    let level = forge.section(b"LEVL") + 64;
    assert_eq!(forge.u32(level + 44), 2);
    forge.put(level + 44, [1]);
    let error = MapReader::from_bytes(forge.sign(), &Limits::default()).unwrap_err().to_string();
    assert_eq!(error, "level 1: its tile directory belongs to another level");
}

#[test]
fn limits_stop_a_file_before_it_takes_memory() {
    type Lower = fn(&mut Limits);
    let cases: [(&str, Lower); 7] = [
        ("bytes of metadata", |limits| limits.max_header_bytes = 10),
        ("levels", |limits| limits.max_levels = 0),
        ("tiles", |limits| limits.max_tiles = 1),
        ("sections", |limits| limits.max_sections = 2),
        ("pixels", |limits| limits.max_pixels = 18),
        ("bytes of a tile", |limits| limits.max_chunk_bytes = 100),
        ("bytes of a file in memory", |limits| limits.max_in_memory_bytes = 1000),
    ];
    for packing in [Packing::Plain, Packing::Zstd] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("map.dsm");
        coloured(packing).write(&path).unwrap();
        for (what, lower) in cases {
            let mut limits = Limits::default();
            lower(&mut limits);
            let read = MapReader::open_in_memory(&path, &limits)
                .and_then(|reader| reader.read_map::<Rgb>(0).map(drop));
            let error = bare_error(read.unwrap_err());
            assert!(matches!(error, Error::Limit { what: found, .. } if found == what), "{error}");
        }
    }
}

#[test]
fn a_packed_map_is_measured_unpacked() {
    let bytes = coloured(Packing::Zstd).bytes();
    let mut limits = Limits::default();
    limits.max_in_memory_bytes = 2 * bytes.len() as u64;
    let read = MapReader::from_bytes(bytes, &limits).unwrap().read_map::<Rgb>(0);
    let error = bare_error(read.unwrap_err());
    assert!(matches!(error, Error::Limit { what: "bytes of a map in memory", .. }), "{error}");
}

#[test]
fn plain_tiles_are_used_where_they_lie() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    for (packing, in_place) in [(Packing::Plain, true), (Packing::Zstd, false)] {
        mono(packing).write(&path).unwrap();
        let limits = Limits::default();
        let mapped = Container::open_mapped(&path, &limits).unwrap();
        let reader = MapReader::new(mapped, &limits).unwrap();
        let tile = reader.tile::<f32>(TileId::default()).unwrap();
        assert_eq!(matches!(tile, Tile::Borrowed(_)), in_place, "{packing:?}");
        // What is read is memory of its own: who changes the file does not change it.
        let reader = MapReader::open(&path, &limits).unwrap();
        assert!(matches!(reader.tile::<f32>(TileId::default()).unwrap(), Tile::Owned(_)));
    }
}

/// A file that begins at an odd address.
#[derive(Debug)]
struct Odd {
    bytes: Vec<u8>,
    start: usize,
}

impl Odd {
    fn new(file: &[u8]) -> Self {
        let mut bytes = vec![0; file.len() + 1];
        let start = 1 - bytes.as_ptr().addr() % 2;
        bytes[start..start + file.len()].copy_from_slice(file);
        Self { bytes, start }
    }
}

impl Source for Odd {
    fn length(&self) -> u64 {
        self.bytes.len() as u64 - 1
    }

    fn read(&self, range: Range<u64>) -> dsm_io::detail::Result<Cow<'_, [u8]>> {
        let [start, end] = [range.start, range.end].map(|at| self.start + at as usize);
        Ok(Cow::Borrowed(&self.bytes[start..end]))
    }
}

#[test]
fn bytes_that_are_not_aligned_are_copied() {
    let bytes = coloured(Packing::Plain).bytes();
    let container = Container::from_source(Odd::new(&bytes), &Limits::default()).unwrap();
    let reader = MapReader::new(container, &Limits::default()).unwrap();
    assert!(reader.verify().is_empty());
    let tile = reader.tile::<Rgb>(TileId::default()).unwrap();
    assert!(matches!(tile, Tile::Owned(_)));
    let aligned = MapReader::from_bytes(bytes, &Limits::default()).unwrap();
    assert_eq!(reader.read_map::<Rgb>(0).unwrap(), aligned.read_map::<Rgb>(0).unwrap());
}
