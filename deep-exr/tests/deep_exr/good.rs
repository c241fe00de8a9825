//! Files by the official writer (`tests/data/generate.py`), whose
//! values follow from the pixel.

use deep_exr::{
    AlphaChannels, ChannelType, DeepExrReader, DeepRows, DeepSample, Error, Layout, Limits, Window,
};

use super::{read_in_bands, small};

const WIDTH: usize = 6;
const HEIGHT: usize = 5;

fn count(x: usize, y: usize) -> usize {
    if y == 2 { 0 } else { (3 * x + 5 * y) % 4 }
}

fn expected(x: usize, y: usize, s: usize, backs: bool, alpha: AlphaChannels) -> DeepSample {
    let z = (4 * y + x + 1) as f32 + s as f32 / 4.0;
    DeepSample {
        z,
        z_back: if backs { z + (s + 1) as f32 / 8.0 } else { z },
        alpha: match alpha {
            AlphaChannels::None => [1.0; 3],
            AlphaChannels::Mono => [(s % 4 + 1) as f32 / 4.0; 3],
            AlphaChannels::Colour => [0, 1, 2].map(|colour| (x + 8 * colour + 1) as f32 / 32.0),
        },
    }
}

fn samples(rows: &DeepRows, pixel: usize) -> Vec<DeepSample> {
    rows.pixel(pixel).map(|index| rows.sample(index)).collect()
}

fn check(name: &str, backs: bool, alpha: AlphaChannels) {
    check_times(name, backs, alpha, 1);
}

/// With `times` as many samples.
fn check_times(name: &str, backs: bool, alpha: AlphaChannels, times: usize) {
    let bytes = small(name);
    for band in [1, 2, 3, 4, 5] {
        let bands = read_in_bands(&bytes, band).unwrap();
        let mut y = 0;
        for rows in &bands {
            assert_eq!((rows.width() as usize, rows.z_back().is_some()), (WIDTH, backs), "{name}");
            assert_eq!(*rows.offsets().last().unwrap() as usize, rows.sample_count());
            for pixel in 0..rows.pixel_count() {
                let (x, y) = (pixel % WIDTH, y + pixel / WIDTH);
                let wanted: Vec<_> =
                    (0..times * count(x, y)).map(|s| expected(x, y, s, backs, alpha)).collect();
                assert_eq!(samples(rows, pixel), wanted, "{name}, pixel {x}, {y}, bands of {band}");
            }
            y += rows.rows() as usize;
        }
        assert_eq!(y, HEIGHT, "{name}");
    }
}

#[test]
fn scan_lines_and_tiles_in_every_compression() {
    check("scan_zips_half.exr", true, AlphaChannels::Colour);
    check("scan_none_float.exr", false, AlphaChannels::Mono);
    check("scan_rle_opaque.exr", true, AlphaChannels::None);
    check("tile_none_float.exr", true, AlphaChannels::Colour);
    check("tile_zips_ids.exr", false, AlphaChannels::Mono);
    check("tile_rle_other_names.exr", false, AlphaChannels::Colour);
    check_times("scan_zstd_mixed.exr", true, AlphaChannels::Mono, 40);
    check_times("scan_zstd_half.exr", true, AlphaChannels::Mono, 40);
    check_times("tile_zstd_float.exr", true, AlphaChannels::Mono, 40);
}

#[test]
fn rows_can_be_read_in_any_order() {
    let mut reader =
        DeepExrReader::from_bytes(small("tile_none_float.exr"), None, &Limits::default()).unwrap();
    for y in [4, 0, 3, 1] {
        let rows = reader.read_rows(y as u32..y as u32 + 1).unwrap();
        for x in 0..WIDTH {
            let wanted: Vec<_> =
                (0..count(x, y)).map(|s| expected(x, y, s, true, AlphaChannels::Colour)).collect();
            assert_eq!(samples(&rows, x), wanted, "pixel {x}, {y}");
        }
    }
    assert_eq!(reader.read_rows(2..2).unwrap().pixel_count(), 0);
    for wrong in [0..6, 6..7] {
        let error = reader.read_rows(wrong).unwrap_err();
        assert!(matches!(error, Error::RowsOutOfRange { height: 5, .. }), "{error}");
    }
}

#[test]
fn the_header_keeps_everything() {
    let reader =
        DeepExrReader::from_bytes(small("scan_zips_half.exr"), None, &Limits::default()).unwrap();
    let header = reader.header();
    assert_eq!(header.data_window, Window { min: [-2, -3], max: [3, 1] });
    assert_eq!(header.display_window, Window { min: [0, 0], max: [7, 7] });
    assert_eq!((header.width, header.height), (6, 5));
    assert_eq!((header.pixel_aspect, header.screen_window_width), (1.0, 1.0));
    assert_eq!((header.deep, header.layout), (true, Layout::ScanLines));
    assert_eq!((header.compression, header.alpha), ("ZIPS", AlphaChannels::Colour));
    assert_eq!((header.has_z_back, header.stated_max_samples), (true, None));
    let channels: Vec<_> = header.channels.iter().map(|channel| channel.name.as_str()).collect();
    assert_eq!(channels, ["A", "AB", "AG", "AR", "Z", "ZBack"]);
    assert!(header.channels.iter().all(|channel| channel.channel_type == ChannelType::Half));
    assert_eq!(header.world_to_camera, Some(std::array::from_fn(|i| i as f32)));
    assert_eq!(header.world_to_ndc, None);
    let free: Vec<_> = header
        .attributes
        .iter()
        .map(|a| (a.name.as_slice(), a.type_name.as_slice(), a.value.as_slice()))
        .collect();
    assert_eq!(free, [(&b"comments"[..], &b"string"[..], &b"kept"[..])]);
}

#[test]
fn parts_are_chosen_by_name_or_depth() {
    let bytes = small("parts.exr");
    let open = |part| DeepExrReader::from_bytes(bytes.clone(), part, &Limits::default());
    let named = |part| open(part).unwrap().header().part_name.clone().unwrap();
    assert_eq!(named(None), "left");
    assert_eq!(named(Some("right")), "right");
    assert_eq!(named(Some("beauty")), "beauty");
    check("parts.exr", false, AlphaChannels::Mono);

    let mut right = open(Some("right")).unwrap();
    assert!(matches!(right.header().layout, Layout::Tiles { width: 4, height: 3, .. }));
    let rows = right.read_rows(0..5).unwrap();
    let pixel = 4 * WIDTH + 1;
    assert_eq!(samples(&rows, pixel)[2], expected(1, 4, 2, true, AlphaChannels::None));

    let error = open(Some("middle")).unwrap_err().to_string();
    assert!(error.contains("'middle'"), "{error}");
    for listed in ["0 'beauty' (scanlineimage: Z)", "1 'left' (deepscanline: A Z)", "2 'right'"] {
        assert!(error.contains(listed), "{error}");
    }
}

#[test]
fn flat_pixels_are_single_samples() {
    for name in ["flat_zip.exr", "flat_tile_piz.exr"] {
        for band in [1, 2, 5] {
            let bands = read_in_bands(&small(name), band).unwrap();
            let all: Vec<_> = bands
                .iter()
                .flat_map(|rows| (0..rows.pixel_count()).map(|pixel| samples(rows, pixel)))
                .collect();
            let wanted: Vec<_> = (0..WIDTH * HEIGHT)
                .map(|pixel| {
                    let (x, y) = (pixel % WIDTH, pixel / WIDTH);
                    let z = (4 * y + x + 1) as f32;
                    vec![DeepSample { z, z_back: z, alpha: [(x + 1) as f32 / 32.0; 3] }]
                })
                .collect();
            assert_eq!(all, wanted, "{name}, bands of {band}");
        }
    }
    let error = read_in_bands(&small("flat_no_depth.exr"), 1).unwrap_err();
    assert!(matches!(error, Error::NoDepth { .. }), "{error}");
    assert!(error.to_string().contains("(scanlineimage: A)"), "{error}");
}

#[test]
fn a_file_on_disk_reads_like_one_in_memory() {
    let bytes = small("tile_zips_ids.exr");
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), &bytes).unwrap();
    let mut reader = DeepExrReader::open(file.path(), None, &Limits::default()).unwrap();
    assert_eq!(reader.read_rows(0..5).unwrap(), super::read(&bytes).unwrap());
    let missing = DeepExrReader::open("no/such.exr".as_ref(), None, &Limits::default());
    assert!(missing.unwrap_err().to_string().contains("no/such.exr"));
    let directory =
        DeepExrReader::open(env!("CARGO_MANIFEST_DIR").as_ref(), None, &Limits::default());
    assert!(matches!(directory.unwrap_err(), Error::Open { .. }));
}
