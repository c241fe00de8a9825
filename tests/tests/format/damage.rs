//! Whatever is damaged is found, behind right checksums too.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use dsm_core::{MapInfo, Vertex};
use dsm_io::detail::{Container, Source};
use dsm_io::{AchievedError, Limits, MapReader, Metadata, Packing, WriteOptions};
use dsm_tests::forge::Forge;
use dsm_tests::{golden, whole_message};
use rayon::prelude::*;

use crate::examples::{Example, coloured, document, mono};
use crate::pixels::build;

/// Everything that is wrong with a file.
fn problems(bytes: Vec<u8>) -> Vec<String> {
    match MapReader::from_bytes(bytes, &Limits::default()) {
        Ok(reader) => reader.verify().into_iter().map(whole_message).collect(),
        Err(error) => vec![whole_message(error)],
    }
}

fn every_kind() -> [Vec<u8>; 6] {
    [
        document().bytes(),
        coloured(Packing::Plain).bytes(),
        mono(Packing::Zstd).bytes(),
        coloured(Packing::Zstd).bytes(),
        coded("mono"),
        coded("rgb"),
    ]
}

/// A map of coded numbers.
fn coded(channels: &str) -> Vec<u8> {
    let name = format!("golden/deep_quantized_entropy_{channels}.dsm");
    std::fs::read(golden::folder().join(name)).unwrap()
}

#[test]
fn every_changed_byte_is_found() {
    for bytes in every_kind() {
        assert!(problems(bytes.clone()).is_empty());
        for position in 0..bytes.len() {
            for flip in [0xff, 1 << (position % 8)] {
                let mut damaged = bytes.clone();
                damaged[position] ^= flip;
                assert!(!problems(damaged).is_empty(), "byte {position} ^ {flip:#x}");
            }
        }
    }
}

/// A file's bytes that a reader borrows, so that none are copied for it.
#[derive(Clone, Debug)]
struct Shared(Arc<Vec<u8>>);

impl Source for Shared {
    fn length(&self) -> u64 {
        self.0.len() as u64
    }

    fn read(&self, range: Range<u64>) -> dsm_io::detail::Result<Cow<'_, [u8]>> {
        Ok(Cow::Borrowed(&self.0[range.start as usize..range.end as usize]))
    }
}

/// 96 × 96 pixels of 16 steps each at depths that don't pack, over a megabyte.
fn large(packing: Packing) -> Vec<u8> {
    let pixel = |index: u64| {
        let mut vertices = Vec::new();
        let mut value = 1.0_f32;
        for step in 0..16_u64 {
            let noise = (random(index * 16 + step) >> 41) as f32 / (1 << 23) as f32;
            let z = 1.0 + step as f32 + noise;
            vertices.push(Vertex::new(z, value));
            value *= 0.875 + noise / 8.0;
            vertices.push(Vertex::new(z, value));
        }
        vertices
    };
    let pixels = build(96, 96, (0..96 * 96).map(pixel));
    let metadata = Metadata::new(96, 96, 1, MapInfo::default());
    let options = WriteOptions::default().with_tile_size(16).with_packing(packing);
    Example { metadata, pixels, error: AchievedError::NONE, options }.bytes()
}

/// Random bytes; every byte of small files is above.
#[test]
fn a_changed_byte_of_a_large_map_is_found() {
    let long = dsm_testkit::is_long();
    let flips: u64 = if long { 10_000 } else { 1000 };
    for packing in [Packing::Plain, Packing::Zstd] {
        let file = large(packing);
        assert!(file.len() > 1 << 20, "{}", file.len());
        let unnoticed: Vec<_> = (0..flips)
            .into_par_iter()
            .map_init(
                || Shared(Arc::new(file.clone())),
                |shared, flip| {
                    let random = random(flip);
                    let position = (random % file.len() as u64) as usize;
                    let mask = 1 << (random >> 61);
                    Arc::get_mut(&mut shared.0).unwrap()[position] ^= mask;
                    let opened = Container::from_source(shared.clone(), &Limits::default())
                        .and_then(|container| MapReader::new(container, &Limits::default()));
                    let found = opened.map_or(true, |reader| !reader.verify().is_empty());
                    Arc::get_mut(&mut shared.0).unwrap()[position] ^= mask;
                    (!found).then_some((position, mask))
                },
            )
            .flatten()
            .collect();
        assert!(unnoticed.is_empty(), "{unnoticed:?}");
    }
}

/// Mixes a number into another (Steele et al., SplitMix64).
fn random(seed: u64) -> u64 {
    let mixed = (seed + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ (mixed >> 31)
}

#[test]
fn every_truncation_and_every_longer_file_is_refused() {
    for bytes in every_kind() {
        for length in 0..bytes.len() {
            let opened = MapReader::from_bytes(bytes[..length].to_vec(), &Limits::default());
            assert!(opened.is_err(), "{length} bytes");
        }
        let longer = [bytes, vec![0]].concat();
        assert_eq!(problems(longer), ["1 bytes follow the end of the map"]);
    }
}

/// A defect: the name of its file, the file it is made in, how, and a part of
/// the error that names it.
pub(crate) struct Defect {
    pub(crate) name: &'static str,
    pub(crate) bytes: Vec<u8>,
    says: &'static str,
}

/// A defect in a signed file.
fn signed(
    name: &'static str,
    file: &[u8],
    says: &'static str,
    change: impl FnOnce(&mut Forge),
) -> Defect {
    let mut forge = Forge(file.to_vec());
    change(&mut forge);
    Defect { name, bytes: forge.sign(), says }
}

fn raw(name: &'static str, bytes: &[u8], says: &'static str) -> Defect {
    Defect { name, bytes: bytes.to_vec(), says }
}

/// Files that are not of this format, or of none that can be read.
fn other_files(file: &[u8]) -> Vec<Defect> {
    let text = file.iter().copied().filter(|&byte| byte != b'\r').collect::<Vec<_>>();
    let mut newer = file.to_vec();
    newer[8] = 2;
    let mut unsigned = file.to_vec();
    unsigned[16] ^= 1;
    vec![
        raw("empty", b"", "the file is empty"),
        raw("tiff", b"II*\0\x08\0\0\0", "TIFF"),
        raw("openexr", b"\x76\x2f\x31\x01\x02\0\0\0", "OpenEXR"),
        raw("of_another_program", b"DSHD\0\0\0\0", "other programs use the same extension"),
        raw("sent_as_text", &text, "text mode"),
        raw("newer_major_version", &newer, "a newer version 2.0"),
        raw("first_bytes_only", &file[..5], "truncated: 5 of 64"),
        raw("prologue_only", &file[..64], "truncated: 64 of"),
        raw("trailing_byte", &[file, b"\0"].concat(), "1 bytes follow the end"),
        raw("prologue_checksum", &unsigned, "prologue: checksum"),
    ]
}

/// Defects of the prologue, the sections and the levels.
fn container(file: &[u8]) -> Vec<Defect> {
    let huge = (1_u64 << 60).to_le_bytes();
    vec![
        signed("length_of_an_exbibyte", file, "truncated", |f| f.put(16, huge)),
        signed("known_section_not_required", file, "flag \"required\" is not set", |f| {
            f.put(f.section_entry(b"META") + 4, [0]);
        }),
        signed("required_flag", file, "flag 0x00000001 is unknown", |f| f.put(12, [1])),
        signed("optional_flag", file, "reserved bytes", |f| f.put(14, [1])),
        signed("reserved_prologue", file, "reserved bytes", |f| f.put(59, [1])),
        signed("table_outside", file, "do not lie in a file", |f| f.put(24, huge)),
        signed("table_unaligned", file, "not a multiple of 64", |f| f.put(24, [1])),
        signed("four_billion_sections", file, "more than the limit", |f| f.put(32, [0xff; 4])),
        signed("no_sections", file, "there is no section", |f| f.put(32, [0; 4])),
        signed("unknown_required_section", file, "section \"NEXT\" is unknown", |f| {
            f.put(f.section_entry(b"META"), *b"NEXT");
        }),
        signed("no_metadata", file, "there is no section \"META\"", |f| {
            f.put(f.section_entry(b"META"), *b"NEXT\0");
        }),
        signed("two_level_sections", file, "another section of this kind", |f| {
            f.put(f.section_entry(b"TDIR"), *b"LEVL");
        }),
        signed("reserved_section", file, "reserved bits", |f| {
            f.put(f.section_entry(b"META") + 28, [1]);
        }),
        signed("section_outside", file, "do not lie in a file", |f| {
            f.put(f.section_entry(b"META") + 8, huge);
        }),
        signed("section_of_an_exbibyte", file, "do not lie in a file", |f| {
            f.put(f.section_entry(b"META") + 16, huge);
        }),
        signed("section_past_the_address_space", file, "do not lie in a file", |f| {
            f.put(f.section_entry(b"META") + 16, [0xff; 8]);
        }),
        signed("unclaimed_bytes", file, "no part of the file claims them", |f| {
            f.0.extend([0; 64]);
            f.put(16, (f.0.len() as u64).to_le_bytes());
        }),
        signed("unclaimed_bytes_between", file, "no part of the file claims them", |f| {
            f.put(f.tile_entry(0), [0; 64]);
        }),
        signed("padding", file, "padding is not zero", |f| {
            f.put(f.section(b"TDIR") - 1, [1]);
        }),
        signed("level_without_pixels", file, "sizes", |f| f.put(f.section(b"LEVL") + 8, [0])),
        signed("level_without_tiles", file, "sizes", |f| f.put(f.section(b"LEVL") + 24, [0])),
        signed("level_of_four_billion_tiles", file, "more than the limit", |f| {
            f.put(f.section(b"LEVL") + 8, [0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff, 0x7f]);
        }),
        signed("level_wider_than_its_directory", file, "one entry a tile", |f| {
            f.put(f.section(b"LEVL") + 8, [5]);
        }),
        signed("level_tolerance", file, "tolerance must lie in", |f| {
            f.put(f.section(b"LEVL") + 32, 1_f32.to_le_bytes());
        }),
        signed("level_error", file, "errors must lie in", |f| {
            f.put(f.section(b"LEVL") + 36, f32::NAN.to_le_bytes());
        }),
        signed("level_error_not_of_tiles", file, "not that of its tiles", |f| {
            f.put(f.section(b"LEVL") + 36, 0.0625_f32.to_le_bytes());
        }),
        signed("level_number", file, "order of their views", |f| {
            f.put(f.section(b"LEVL") + 4, [1]);
        }),
        signed("level_directory", file, "no such section", |f| {
            f.put(f.section(b"LEVL") + 44, [0]);
        }),
        signed("level_reserved", file, "reserved bytes", |f| f.put(f.section(b"LEVL") + 63, [1])),
    ]
}

/// Defects of the metadata.
fn metadata(file: &[u8]) -> Vec<Defect> {
    vec![
        signed("metadata_not_json", file, "metadata: ", |f| f.replace("{", "[")),
        signed("another_kind_of_map", file, "kind \"mtsm\"", |f| f.replace("deep", "mtsm")),
        signed("two_channels", file, "channels must be", |f| {
            f.replace("channels\":1", "channels\":2");
        }),
        signed("metadata_without_width", file, "missing field `width`", |f| {
            f.replace("width", "depth");
        }),
        signed("metadata_of_another_size", file, "another size", |f| {
            f.replace("width\":3", "width\":4");
        }),
        signed("metadata_tolerance", file, "tolerance must lie", |f| {
            f.replace("0.0625", "6.2500");
        }),
        signed("metadata_of_another_tolerance", file, "another tolerance", |f| {
            f.replace("0.0625", "0.0626");
        }),
    ]
}

/// Defects of tiles and their directory entries. The document's example has
/// its payload's words at: 0 pixel table, 12 depths, 28 values.
fn tiles(file: &[u8]) -> Vec<Defect> {
    let entry = |at: usize, byte: u8| move |f: &mut Forge| f.put(f.tile_entry(0) + at, [byte]);
    let word =
        |at: usize, value: f32| move |f: &mut Forge| f.put(f.payload(0) + at, value.to_le_bytes());
    let table = |at: usize, value: u8| move |f: &mut Forge| f.put(f.payload(0) + at, [value]);
    vec![
        signed("tile_on_the_prologue", file, "overlaps another part", |f| {
            f.put(f.tile_entry(1), *b"\x40\0\0\0\0\0\0\0\x04\0\0\0\0\0\0\0\x04");
        }),
        signed("tile_outside", file, "do not lie in a file", entry(5, 1)),
        signed("empty_tile_with_vertices", file, "nothing but its error", |f| {
            f.put(f.tile_entry(1) + 24, [1]);
        }),
        signed("tile_without_payload", file, "must have a payload", entry(16, 0)),
        signed("tile_depth_nan", file, "depths must be finite", entry(35, 0xff)),
        signed("tile_depth_range", file, "not the range", entry(38, 0xb0)),
        signed("tile_error", file, "errors must lie in", entry(43, 0xbf)),
        signed("tile_error_above_tolerance", file, "more than the level's tolerance", |f| {
            f.put(f.tile_entry(0) + 40, 0.5_f32.to_le_bytes());
        }),
        signed("tile_depth_error", file, "depths must be finite", entry(51, 0xbf)),
        signed("unknown_codec", file, "codec 200 is unknown", entry(56, 200)),
        signed("unknown_block", file, "block 200 is unknown", entry(57, 200)),
        signed("plain_differences", file, "stores words", entry(58, 1)),
        signed("tile_reserved", file, "reserved bytes", entry(63, 1)),
        signed("raw_length_not_of_words", file, "not a multiple of 4", entry(16, 45)),
        signed("raw_length_too_short", file, "no room", entry(16, 12)),
        signed("raw_length_too_long", file, "does not fit its number", entry(16, 48)),
        signed("raw_length_of_an_exbibyte", file, "more than the limit", entry(23, 0x10)),
        signed("vertex_count", file, "does not fit its number", entry(24, 3)),
        signed("vertex_count_huge", file, "no room", entry(31, 0xff)),
        signed("pixel_table_start", file, "does not cover the vertices", table(0, 1)),
        signed("pixel_table_falls", file, "does not cover the vertices", table(4, 9)),
        signed("pixel_table_end", file, "does not cover the vertices", table(8, 3)),
        signed("depth_infinite", file, "z must be finite", word(24, f32::INFINITY)),
        signed("depth_nan", file, "z must be finite", word(12, f32::NAN)),
        signed("depth_negative", file, "z must be finite", word(12, -1.0)),
        signed("depth_falls", file, "z must not decrease", word(20, 6.0)),
        signed("value_first", file, "first value must be 1", word(28, 0.5)),
        signed("value_rises", file, "must not increase", word(32, 1.5)),
        signed("value_nan", file, "must not increase", word(32, f32::NAN)),
        signed("value_negative", file, "must not be negative", word(32, -0.5)),
        signed("three_vertices_at_one_depth", file, "two vertices may share", |f| {
            // One pixel of three vertices, the other of one.
            f.put(f.payload(0) + 4, [3]);
            f.put(f.payload(0) + 20, 2_f32.to_le_bytes());
        }),
    ]
}

/// Defects that only coloured tiles can have. Tile 0 has 8 × 8 pixels: after
/// the pixel tables of 65 words each come two words of flags.
fn coloured_tiles(file: &[u8]) -> Vec<Defect> {
    vec![
        signed("mono_flag", file, "mono flags", |f| {
            let at = f.payload(0) + 2 * 65 * 4;
            f.put(at, [f.0[at] ^ 1]);
        }),
        signed("value_table", file, "does not cover the values", |f| {
            f.put(f.payload(0) + 65 * 4, [1]);
        }),
    ]
}

/// Defects that only packed tiles can have.
fn packed_tiles(file: &[u8]) -> Vec<Defect> {
    fn more_vertices(f: &mut Forge, more: i64) {
        let entry = f.tile_entry(0);
        for (at, each) in [(16, 8), (24, 1)] {
            let changed = f.u64(entry + at).wrapping_add_signed(more * each);
            f.put(entry + at, changed.to_le_bytes());
        }
    }
    vec![
        signed("frame_longer_than_stated", file, "damaged or larger", |f| more_vertices(f, -1)),
        signed("frame_shorter_than_stated", file, "smaller than stated", |f| more_vertices(f, 1)),
        signed("frame_damaged", file, "zstd frame", |f| f.put(f.payload(0), [0; 4])),
        signed("bytes_after_the_frame", file, "not exactly one zstd frame", |f| {
            let at = f.tile_entry(0) + 8;
            f.put(at, (f.u64(at) + 1).to_le_bytes());
        }),
        signed("differences_of_no_column", file, "fewer columns", |f| {
            f.put(f.tile_entry(0) + 58, [0x20]);
        }),
    ]
}

/// Every defect but those in files that a newer zstd may write otherwise.
pub(crate) fn defects() -> Vec<Defect> {
    let (file, colour) = (document().bytes(), coloured(Packing::Plain).bytes());
    let mut defects = other_files(&file);
    defects.extend(container(&file));
    defects.extend(metadata(&file));
    defects.extend(tiles(&file));
    defects.extend(coloured_tiles(&colour));
    defects
}

#[test]
fn every_defect_is_named() {
    let packed = packed_tiles(&mono(Packing::Zstd).bytes());
    let unnamed: Vec<_> = defects()
        .into_iter()
        .chain(packed)
        .map(|Defect { name, bytes, says }| (name, says, problems(bytes)))
        .filter(|(_, says, found)| !found.iter().any(|problem| problem.contains(says)))
        .collect();
    assert!(unnamed.is_empty(), "{unnamed:#?}");
}

#[test]
fn verify_finds_more_than_the_first_problem() {
    let mut forge = Forge(coloured(Packing::Plain).bytes());
    for tile in [0, 1] {
        let at = forge.payload(tile);
        forge.put(at, [7]);
    }
    let problems = problems(forge.0);
    assert_eq!(problems.len(), 2, "{problems:?}");
    assert!(problems[1].starts_with("tile (1, 0) of level 0 at byte "), "{problems:?}");
}
