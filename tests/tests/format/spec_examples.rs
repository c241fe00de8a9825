//! The document's example is the file it says it is.

use std::path::Path;

use dsm_io::detail::TileId;
use dsm_io::{Limits, MapReader};
use dsm_tests::forge::crc32c;

use crate::examples::document;

fn specification() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/format/dsm-1.md");
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The bytes of all lines `address | hexadecimal digits | text`.
fn hex_dump(text: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    for line in text.lines() {
        let Some((address, rest)) = line.split_once("  ") else { continue };
        let Ok(address) = usize::from_str_radix(address, 16) else { continue };
        assert_eq!(address, bytes.len(), "{line}");
        let digits = rest.split("  |").next().unwrap().split_ascii_whitespace();
        bytes.extend(digits.map(|byte| u8::from_str_radix(byte, 16).unwrap()));
    }
    bytes
}

#[test]
fn the_example_is_what_the_writer_writes() {
    let bytes = hex_dump(&specification());
    let written = document().bytes();
    assert_eq!(bytes.len(), written.len());
    let different = (0..bytes.len()).find(|&index| bytes[index] != written[index]);
    assert_eq!(different, None);
}

#[test]
fn the_example_reads_as_the_document_says() {
    let reader = MapReader::from_bytes(hex_dump(&specification()), &Limits::default()).unwrap();
    assert!(reader.verify().is_empty());
    assert_eq!([reader.metadata().width, reader.metadata().height], [3, 1]);
    assert_eq!(reader.metadata().info.tolerance.epsilon(), 0.0625);
    let map = reader.read_map::<f32>(0).unwrap();
    for (x, z, before, at) in [
        (0, 1.0, 1.0, 1.0),
        (0, 2.0, 1.0, 0.25),
        (0, 9.0, 0.25, 0.25),
        (1, 4.0, 0.75, 0.75),
        (1, 5.0, 0.5, 0.5),
        (2, 5.0, 1.0, 1.0),
    ] {
        assert_eq!((map.pixel(x, 0).before(z), map.pixel(x, 0).at(z)), (before, at), "{x} {z}");
        let row = format!("| {x} | {z} | {before} | {at} |");
        assert!(specification().contains(&row), "the document has no row {row}");
    }
    let entry = *reader.directory(0).unwrap().get(0, 0).unwrap();
    assert_eq!((entry.offset, entry.stored_length, entry.vertex_count), (64, 44, 4));
    assert!(reader.directory(0).unwrap().get(1, 0).unwrap().is_empty());
    assert_eq!(reader.tile_rect(TileId::new(0, 1, 0)).unwrap().width, 1);
}

#[test]
fn the_stated_checksum_is_the_one_that_is_used() {
    assert!(specification().contains("E3069283"));
    assert_eq!(crc32c(b"123456789"), 0xe306_9283);
}
