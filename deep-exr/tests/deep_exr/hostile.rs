//! Files that no writer makes: rare but allowed, and hostile ones.

use deep_exr::{DeepExrReader, DeepRows, Error, Layout, Limits};

use super::assemble::{
    Part, SCAN_CHANNELS, channel_list, chunk, file, half_then_two, scan_part, tiles, window,
};
use super::read;

fn counts(rows: &DeepRows) -> Vec<usize> {
    (0..rows.pixel_count()).map(|pixel| rows.pixel(pixel).len()).collect()
}

fn error(part: Part) -> Error {
    read(&file(&[part]).0).unwrap_err()
}

/// The error is of this kind and says this.
macro_rules! assert_error {
    ($error:expr, $kind:pat, $($text:literal),+) => {
        let error = $error;
        assert!(matches!(error, $kind), "{error:?}");
        for text in [$($text),+] {
            assert!(error.to_string().contains(text), "{text:?} is not in: {error}");
        }
    };
}

#[test]
fn the_assembled_file_is_sound() {
    let (bytes, _) = file(&[scan_part()]);
    let rows = read(&bytes).unwrap();
    assert_eq!(counts(&rows), [1, 0, 1, 0, 1, 0]);
    let sample = rows.sample(2);
    assert_eq!((sample.z, sample.z_back, sample.alpha), (2.0, 2.0, [0.5; 3]));
}

#[test]
fn an_unknown_largest_number_of_samples_is_allowed() {
    let part = scan_part().with("maxSamplesPerPixel", "int", (-1_i32).to_le_bytes().to_vec());
    let (bytes, _) = file(&[part]);
    let reader = DeepExrReader::from_bytes(bytes.clone(), None, &Limits::default()).unwrap();
    assert_eq!(reader.header().stated_max_samples, None);
    assert_eq!(read(&bytes).unwrap().sample_count(), 3);
}

/// 3 × 2 pixels in tiles of 2 × 2, then smaller levels.
fn mip_mapped(mode: u8, smaller_levels: &[&[i32]], cut_tables_are_whole: bool) -> Part {
    let sample = half_then_two();
    let mut chunks = vec![chunk(&[0, 0, 0, 0], &[&[1, 0], &[0, 1]], &sample)];
    let cut: &[&[u32]] = if cut_tables_are_whole { &[&[1], &[0], &[0, 0]] } else { &[&[1], &[0]] };
    chunks.push(chunk(&[1, 0, 0, 0], cut, &sample));
    chunks.extend(smaller_levels.iter().map(|level| chunk(level, &[&[7]], &sample)));
    Part {
        attributes: vec![
            ("channels", "chlist", channel_list(&SCAN_CHANNELS, 1)),
            ("compression", "compression", vec![0]),
            ("dataWindow", "box2i", window(0, 0, 2, 1)),
            ("tiles", "tiledesc", tiles(2, 2, mode)),
            ("type", "string", b"deeptile".to_vec()),
        ],
        chunks,
    }
}

#[test]
fn the_largest_level_of_mip_and_rip_maps_is_read() {
    let mip = mip_mapped(1, &[&[0, 0, 1, 1]], false);
    let rip = mip_mapped(2, &[&[0, 0, 1, 0], &[0, 0, 0, 1], &[1, 0, 0, 1], &[0, 0, 1, 1]], false);
    for (part, others) in [(mip, 1), (rip, 4)] {
        let (bytes, _) = file(std::slice::from_ref(&part));
        assert_eq!(counts(&read(&bytes).unwrap()), [1, 0, 1, 0, 1, 0]);
        let reader = DeepExrReader::from_bytes(bytes, None, &Limits::default()).unwrap();
        assert_eq!(reader.header().layout, Layout::Tiles { width: 2, height: 2 });
        assert!(reader.header().has_levels);
        // The number of chunks counts the smaller levels too.
        let right = part.chunks.len() as i32;
        assert_eq!(right, 2 + others);
        let stated =
            |count: i32| part.clone().with("chunkCount", "int", count.to_le_bytes().into());
        assert!(read(&file(&[stated(right)]).0).is_ok());
        assert_error!(error(stated(right - 1)), Error::Header { .. }, "chunkCount");
    }
}

#[test]
fn tables_of_cut_tiles_may_be_stored_whole() {
    let (bytes, _) = file(&[mip_mapped(0, &[], true)]);
    assert_eq!(counts(&read(&bytes).unwrap()), [1, 0, 1, 0, 1, 0]);
}

#[test]
fn compressions_are_refused_by_name() {
    let with = |id| error(scan_part().with("compression", "compression", vec![id]));
    assert_error!(with(10), Error::UnsupportedCompression { .. }, "with HTJ2K256, ");
    assert_error!(with(3), Error::UnsupportedCompression { .. }, "with ZIP, ", "deep");
    assert_error!(with(9), Error::UnsupportedCompression { .. }, "with DWAB, ");
    assert_error!(with(77), Error::UnsupportedCompression { .. }, "method 77");
}

#[test]
fn other_files_are_named() {
    let named = |bytes: &[u8]| read(bytes).unwrap_err();
    assert_error!(named(b""), Error::NotExr { .. }, "empty");
    assert_error!(named(b"\x89DSM\r\n\x1a\n...."), Error::NotExr { .. }, ".dsm");
    assert_error!(named(b"MM\0*........"), Error::NotExr { .. }, "TIFF");
    assert_error!(named(b"plain text"), Error::NotExr { .. }, "70 6c 61 69");
    let (good, _) = file(&[scan_part()]);
    let changed = |index: usize, value| {
        let mut bytes = good.clone();
        bytes[index] = value;
        read(&bytes).unwrap_err()
    };
    assert_error!(changed(4, 3), Error::UnsupportedVersion { .. }, "version 3");
    assert_error!(changed(6, 1), Error::UnsupportedVersion { .. }, "flags");
}

#[test]
fn windows_and_tiles_out_of_bounds() {
    let with =
        |x0, y0, x1, y1| error(scan_part().with("dataWindow", "box2i", window(x0, y0, x1, y1)));
    assert_error!(with(5, 0, 4, 0), Error::Header { .. }, "no pixels");
    assert_error!(with(i32::MIN, 0, i32::MAX, 0), Error::Header { .. }, "2^30");
    let far = 1 << 29;
    assert_error!(with(-far, -far, far, far), Error::LimitExceeded { .. }, "pixels");
    // 2^28 pixels are allowed, but not in a file this short.
    assert_error!(with(0, 0, (1 << 28) - 1, 0), Error::Header { .. }, "at most");
    assert_error!(with(4, -1, 5, 2), Error::Chunk { .. }, "scan line -1");
    for (width, height, mode) in [(0, 2, 0), (2, 0, 0), (1 << 31, 2, 0), (2, 2, 3), (2, 2, 0x21)] {
        let part = mip_mapped(0, &[], false).with("tiles", "tiledesc", tiles(width, height, mode));
        assert_error!(error(part), Error::Header { .. }, "'tiles'");
    }
    // A tile larger than the image is fine, and so is its size in memory.
    let large = mip_mapped(0, &[], false).with("tiles", "tiledesc", tiles(1 << 29, 1 << 29, 0));
    assert_error!(error(large), Error::Chunk { .. }, "tile (0, 0)");
}

#[test]
fn channels_and_attributes_that_make_no_sense() {
    let with = |list| error(scan_part().with("channels", "chlist", list));
    assert_error!(with(channel_list(&SCAN_CHANNELS, 2)), Error::Header { .. }, "subsampled");
    let sorted = [("Z", 2), ("A", 1)];
    assert_error!(with(channel_list(&sorted, 1)), Error::Header { .. }, "not in order");
    let twice = [("Z", 2), ("Z", 2)];
    assert_error!(with(channel_list(&twice, 1)), Error::Header { .. }, "not in order");
    assert_error!(with(channel_list(&[("A", 1)], 1)), Error::Channels { .. }, "channels are A");
    assert_error!(with(channel_list(&[("Z", 9)], 1)), Error::Header { .. }, "'channels'");
    assert_error!(with(vec![0]), Error::Channels { .. }, "Z");
    assert_error!(with(vec![]), Error::Header { .. }, "'channels'");
    for name in ["channels", "compression", "dataWindow"] {
        assert_error!(error(scan_part().without(name)), Error::Header { .. }, "missing");
    }
    let mut twice = scan_part();
    twice.attributes.push(("compression", "compression", vec![0]));
    assert_error!(error(twice), Error::Header { .. }, "twice");
    let wrong = scan_part().with("dataWindow", "box2f", window(0, 0, 1, 1));
    assert_error!(error(wrong), Error::Header { .. }, "'box2f'");
    let wrong = scan_part().with("type", "string", b"deepvoxels".to_vec());
    assert_error!(error(wrong), Error::NoDepth { .. }, "deepvoxels");
}

#[test]
fn limits_are_the_callers() {
    let (bytes, _) = file(&[scan_part()]);
    let reads = |change: fn(&mut Limits)| {
        let mut limits = Limits::default();
        change(&mut limits);
        DeepExrReader::from_bytes(bytes.clone(), None, &limits)?.read_rows(0..3)
    };
    assert!(reads(|limits| limits.max_pixels = 6).is_ok());
    assert_error!(reads(|l| l.max_pixels = 5).unwrap_err(), Error::LimitExceeded { .. }, "5");
    assert_error!(
        reads(|l| l.max_attributes = 3).unwrap_err(),
        Error::LimitExceeded { .. },
        "attributes"
    );
    assert_error!(
        reads(|l| l.max_header_bytes = 99).unwrap_err(),
        Error::LimitExceeded { .. },
        "headers"
    );
    assert_error!(
        reads(|l| l.max_channels = 1).unwrap_err(),
        Error::LimitExceeded { .. },
        "channels"
    );
    assert_error!(reads(|l| l.max_parts = 0).unwrap_err(), Error::LimitExceeded { .. }, "parts");
    assert_error!(
        reads(|l| l.max_chunk_bytes = 7).unwrap_err(),
        Error::LimitExceeded { .. },
        "table"
    );
    assert_error!(
        reads(|l| l.max_samples_per_pixel = 0).unwrap_err(),
        Error::Chunk { .. },
        "0 samples"
    );
    // Six entries and three samples of eight bytes.
    assert!(reads(|l| l.max_answer_bytes = 48).is_ok());
    assert_error!(
        reads(|l| l.max_answer_bytes = 47).unwrap_err(),
        Error::LimitExceeded { .. },
        "rows"
    );
}

#[test]
fn offsets_that_lead_astray() {
    let (good, tables) = file(&[scan_part()]);
    let entry = |line: usize| tables[0] + 8 * line;
    let patched = |line: usize, offset: u64| {
        let mut bytes = good.clone();
        bytes[entry(line)..entry(line) + 8].copy_from_slice(&offset.to_le_bytes());
        bytes
    };
    // Where none can be the place of a chunk, it is found by looking for it.
    for offset in [0, 8, good.len() as u64, u64::MAX] {
        let bytes = patched(1, offset);
        assert_eq!(read(&bytes).unwrap(), read(&good).unwrap(), "{offset}");
        let reader = DeepExrReader::from_bytes(bytes, None, &Limits::default()).unwrap();
        assert_eq!(reader.header().found_chunks, 1);
    }
    let first = u64::from_le_bytes(good[entry(0)..entry(1)].try_into().unwrap());
    assert_error!(read(&patched(1, first)).unwrap_err(), Error::Chunk { .. }, "scan line [-1]");
    // The other lines can still be read.
    let mut bytes = good.clone();
    bytes[entry(1)] = 0xff;
    let mut reader = DeepExrReader::from_bytes(bytes, None, &Limits::default()).unwrap();
    assert!(reader.read_rows(0..3).is_err());
    assert_eq!(reader.read_rows(2..3).unwrap().sample_count(), 1);
}

#[test]
fn chunks_of_other_parts() {
    let stated = scan_part().with("chunkCount", "int", 3_i32.to_le_bytes().to_vec());
    let named = |name: &str| stated.clone().with("name", "string", name.as_bytes().to_vec());
    let parts = [named("one"), named("two")];
    let (mut bytes, tables) = file(&parts);
    let second = |bytes: &[u8]| {
        let mut reader =
            DeepExrReader::from_bytes(bytes.to_vec(), Some("two"), &Limits::default())?;
        reader.read_rows(0..3)
    };
    assert_eq!(second(&bytes).unwrap().sample_count(), 3);
    bytes.copy_within(tables[0]..tables[0] + 8, tables[1]);
    assert_error!(second(&bytes).unwrap_err(), Error::Chunk { .. }, "part 0");
    let unstated = [named("one").without("chunkCount"), named("two")];
    assert_error!(second(&file(&unstated).0).unwrap_err(), Error::Header { .. }, "chunkCount");
}

#[test]
fn tables_and_sizes_that_lie() {
    let line = |counts: &[u32]| chunk(&[-1], &[counts], &half_then_two());
    let with = |first: Vec<u8>| {
        let mut part = scan_part();
        part.chunks[0] = first;
        error(part)
    };
    let patched = |at: usize, value: &[u8]| {
        let mut chunk = line(&[1, 0]);
        chunk[at..at + value.len()].copy_from_slice(value);
        with(chunk)
    };
    let huge = (1_u64 << 62).to_le_bytes();
    // Offsets in a chunk: 4 table size, 12 and 20 sample sizes, 28 table.
    assert_error!(patched(4, &huge), Error::Chunk { .. }, "scan line -1", "bytes");
    assert_error!(patched(12, &huge), Error::Chunk { .. }, "bytes");
    assert_error!(patched(20, &huge), Error::LimitExceeded { .. }, "scan line -1");
    assert_error!(patched(20, &5_u64.to_le_bytes()), Error::Chunk { .. }, "whole number");
    assert_error!(patched(20, &0_u64.to_le_bytes()), Error::Chunk { .. }, "room for 0");
    assert_error!(patched(28, &2_u32.to_le_bytes()), Error::Chunk { .. }, "after 2");
    assert_error!(patched(32, &2_u32.to_le_bytes()), Error::Chunk { .. }, "2 samples");
    assert_error!(patched(32, &u32::MAX.to_le_bytes()), Error::Chunk { .. }, "at most 1048576");
    let mut spare = line(&[2, 0]);
    spare[28] = 1;
    spare[32] = 1;
    assert_error!(with(spare), Error::Chunk { .. }, "1 samples counted, room for 2");
    // Counts that fall are refused even where any number of samples is allowed.
    let mut falling = scan_part();
    falling.chunks[0] = line(&[1, 0]);
    falling.chunks[0][28] = 2;
    let limits = {
        let mut limits = Limits::default();
        limits.max_samples_per_pixel = u32::MAX;
        limits
    };
    let mut reader = DeepExrReader::from_bytes(file(&[falling]).0, None, &limits).unwrap();
    assert_error!(reader.read_rows(0..3).unwrap_err(), Error::Chunk { .. }, "1 after 2");
}
