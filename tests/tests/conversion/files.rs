//! What a conversion keeps, adds up and leaves alone.

use std::fs;
use std::path::Path;

use dsm_core::detail::PixelWindow;
use dsm_core::{MapInfo, PixelListsBuilder, Progress, Vertex};
use dsm_io::deep_exr::{self, DeepExrReader, Window};
use dsm_io::detail::{MapWriter, TileId, compare};
use dsm_io::{
    AchievedError, Attribute, Limits, MapReader, MapSource, Metadata, Packing, WriteOptions,
    convert,
};

use super::{IMAGES, converted, image, open, options, z_turned};

#[test]
fn a_copy_has_the_same_functions_whatever_its_tiles_and_blocks() {
    let folder = tempfile::tempdir().unwrap();
    for name in IMAGES {
        let original = folder.path().join("original.dsm");
        convert(&mut open(&image(name)), &original, &options(0.01, 64), Progress::ignore).unwrap();
        for packing in [Packing::Plain, Packing::Zstd] {
            let mut options = options(0.0, 7);
            options.write = options.write.with_packing(packing);
            let copy = converted(&original, folder.path(), &options);
            let difference =
                compare(&mut open(&original), &mut open(&copy), Progress::ignore).unwrap();
            assert_eq!(difference.max(), 0.0, "{name}");
            let metadata =
                |path| MapReader::open(path, &Limits::default()).unwrap().metadata().clone();
            assert_eq!(metadata(&copy), metadata(&original), "{name}");
        }
    }
}

#[test]
fn tolerances_of_conversions_in_turn_add_up() {
    let folder = tempfile::tempdir().unwrap();
    let name = "scan_zips_half.exr";
    let first = folder.path().join("first.dsm");
    convert(&mut open(&image(name)), &first, &options(0.03, 16), Progress::ignore).unwrap();
    let second = converted(&first, folder.path(), &options(0.05, 16));
    let reader = MapReader::open(&second, &Limits::default()).unwrap();
    assert_eq!(reader.metadata().info.tolerance.epsilon(), 0.03 + 0.05);
    let (whole, source) = (reader.levels()[0].error, {
        MapReader::open(&first, &Limits::default()).unwrap().levels()[0].error
    });
    assert!(0.0 < source.max && source.max < whole.max && whole.max <= 0.08);
    assert!(0.0 < source.mean && source.mean < whole.mean);
    dsm_io::detail::check_bound(reader, &mut open(&image(name)), Progress::ignore).unwrap();
    let far = options(0.99, 16);
    assert!(
        convert(&mut open(&second), &folder.path().join("far.dsm"), &far, Progress::ignore)
            .is_err()
    );
    assert!(!folder.path().join("far.dsm").exists());
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let path = pool
            .install(|| converted(&image("scan_zips_half.exr"), folder.path(), &options(0.02, 4)));
        fs::read(path).unwrap()
    };
    assert_eq!(bytes(1), bytes(5));
}

#[test]
fn an_image_that_breaks_off_leaves_the_old_map() {
    let folder = tempfile::tempdir().unwrap();
    let whole = fs::read(image("scan_none_float.exr")).unwrap();
    let broken = folder.path().join("broken.exr");
    fs::write(&broken, &whole[..whole.len() - 9]).unwrap();
    let output = folder.path().join("map.dsm");
    fs::write(&output, b"the old one").unwrap();
    let failed = MapSource::open(&broken, None, &Limits::default())
        .and_then(|mut source| convert(&mut source, &output, &options(0.0, 1), Progress::ignore));
    assert!(failed.is_err());
    assert_eq!(fs::read(&output).unwrap(), b"the old one");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "no other file is left");
}

#[test]
fn windows_cameras_and_attributes_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    for name in IMAGES {
        let reader = DeepExrReader::open(&image(name), None, &deep_exr::Limits::default()).unwrap();
        let header = reader.header();
        let path = converted(&image(name), folder.path(), &options(0.0, 64));
        let map = MapReader::open(&path, &Limits::default()).unwrap();
        let metadata = map.metadata();
        let pixels = |Window { min, max }| Some(PixelWindow { min, max });
        assert_eq!(metadata.info.data_window, pixels(header.data_window));
        assert_eq!(metadata.info.display_window, pixels(header.display_window));
        let part_name = metadata.attributes.get("name").and_then(Attribute::as_text);
        assert_eq!(part_name, header.part_name.as_deref());
        let named = usize::from(part_name.is_some());
        assert_eq!(metadata.attributes.len(), header.attributes.len() + named);
        for attribute in &header.attributes {
            let kept = &metadata.attributes[&*attribute.name_text()];
            assert_eq!(kept.type_name().as_bytes(), attribute.type_name);
            assert_eq!(kept.bytes(), attribute.value);
        }
        let camera = metadata.info.camera;
        let columns = |matrix: Option<glam::DMat4>| {
            matrix.map(|matrix| matrix.to_cols_array().map(|number| number as f32))
        };
        // Rows of the file's row-vector matrix are columns of ours, which looks down
        // −z where OpenEXR's camera looks along +z.
        let turned = header.world_to_camera.map(z_turned);
        assert_eq!(columns(camera.and_then(|c| c.world_to_camera)), turned);
        assert_eq!(columns(camera.and_then(|c| c.world_to_ndc)), header.world_to_ndc);
    }
}

/// A sound file of an empty map of any size, in one tile.
fn empty_map(size: u32, path: &Path) {
    let metadata = Metadata::new(size, size, 1, MapInfo::default());
    let options = WriteOptions::default().with_tile_size(size);
    MapWriter::create(path, metadata, options).unwrap().finish().unwrap();
}

#[test]
fn a_huge_map_is_refused_before_memory_is_taken_for_it() {
    let folder = tempfile::tempdir().unwrap();
    let huge = folder.path().join("huge.dsm");
    empty_map(i32::MAX as u32, &huge);
    let opened = MapSource::open(&huge, None, &Limits::default());
    assert!(opened.is_err_and(|error| error.to_string().contains("pixels")));
}

#[test]
fn what_readers_would_refuse_is_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let (map, output) = (folder.path().join("map.dsm"), folder.path().join("output.dsm"));
    empty_map(2100, &map);
    let many_tiles = convert(&mut open(&map), &output, &options(0.0, 1), Progress::ignore);
    assert!(many_tiles.is_err_and(|error| error.to_string().contains("tiles")));
    let mut metadata = Metadata::new(1, 1, 1, MapInfo::default());
    // A control character takes six bytes in JSON.
    metadata.attributes.insert("long".into(), Attribute::string(&"\u{1}".repeat(3_000_000)));
    let long = MapWriter::create(&output, metadata, WriteOptions::default());
    assert!(long.is_err_and(|error| error.to_string().contains("metadata")));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "only the source is there");
}

#[test]
fn only_regular_files_are_sources() {
    let folder = tempfile::tempdir().unwrap();
    let opened = MapSource::open(folder.path(), None, &Limits::default());
    assert!(opened.is_err_and(|error| error.to_string().contains("not a regular file")));
}

#[test]
fn a_part_is_chosen_by_name_and_a_map_has_none() {
    let limits = Limits::default();
    let path = image("parts.exr");
    let MapSource::Image(first) = open(&path) else { panic!("parts.exr is an image") };
    let name = first.header().part_name.clone().unwrap();
    assert!(MapSource::open(&path, Some(name.as_str()), &limits).is_ok());
    assert!(MapSource::open(&path, Some("no such part"), &limits).is_err());
    let folder = tempfile::tempdir().unwrap();
    let map = converted(&path, folder.path(), &options(0.0, 64));
    assert!(MapSource::open(&map, Some(name.as_str()), &limits).is_err());
}

/// A map of 40 × 30 pixels in tiles of 8 of which only those in `tiles` hold
/// something: a step whose depth tells the pixel.
fn sparse_map(path: &Path, tiles: &[[u32; 2]]) {
    let metadata = Metadata::new(40, 30, 1, MapInfo::default());
    let options = WriteOptions::default().with_tile_size(8);
    let mut writer = MapWriter::create(path, metadata, options).unwrap();
    for &[x, y] in tiles {
        let rect = writer.levels()[0].tile_rect(x, y).unwrap();
        let mut pixels = PixelListsBuilder::new(rect.width, rect.height);
        for pixel in 0..rect.width * rect.height {
            let z = (1 + (y * 8 + pixel / rect.width) * 40 + x * 8 + pixel % rect.width) as f32;
            pixels.push(Vertex::new(z, 1.0_f32));
            pixels.push(Vertex::new(z, 0.5));
            pixels.finish_pixel().unwrap();
        }
        let pixels = pixels.finish().unwrap();
        writer.write_tile(TileId::new(0, x, y), pixels.view(), AchievedError::NONE).unwrap();
    }
    writer.finish().unwrap();
}

#[test]
fn empty_tiles_are_left_out_and_the_others_stay_where_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let sparse = folder.path().join("sparse.dsm");
    for occupied in [&[][..], &[[1, 1]], &[[0, 0], [4, 3], [2, 1]], &[[4, 0], [0, 3]]] {
        sparse_map(&sparse, occupied);
        for tile in [1, 3, 5, 8, 16, 64] {
            let copy = converted(&sparse, folder.path(), &options(0.0, tile));
            let reader = MapReader::open(&copy, &Limits::default()).unwrap();
            let map = reader.read_map::<f32>(0).unwrap();
            for (y, x) in (0..30).flat_map(|y| (0..40).map(move |x| (y, x))) {
                let function = map.pixel(x, y);
                if occupied.contains(&[x / 8, y / 8]) {
                    assert_eq!(function.depths(), [(1 + y * 40 + x) as f32; 2], "{x}, {y}");
                } else {
                    assert!(function.is_empty(), "{x}, {y}");
                }
            }
            for (id, entry) in reader.directory(0).unwrap().iter() {
                let rect = reader.tile_rect(id).unwrap();
                let overlaps = |&[x, y]: &[u32; 2]| {
                    rect.x < x * 8 + 8
                        && x * 8 < rect.x + rect.width
                        && rect.y < y * 8 + 8
                        && y * 8 < rect.y + rect.height
                };
                assert_eq!(entry.is_empty(), !occupied.iter().any(overlaps), "{id}");
            }
        }
    }
}

/// A pixel at a time, this takes many seconds.
#[test]
fn an_empty_map_is_copied_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let empty = folder.path().join("empty.dsm");
    let metadata = Metadata::new(16_384, 16_384, 3, MapInfo::default());
    let options_of = WriteOptions::default().with_tile_size(256);
    MapWriter::create(&empty, metadata, options_of).unwrap().finish().unwrap();
    let clock = std::time::Instant::now();
    let copy = converted(&empty, folder.path(), &options(0.01, 128));
    assert!(clock.elapsed().as_secs_f64() < 20.0, "{:?}", clock.elapsed());
    let reader = MapReader::open(&copy, &Limits::default()).unwrap();
    assert_eq!(reader.levels()[0].tile_count(), 128 * 128);
    assert!(reader.directory(0).unwrap().iter().all(|(_, entry)| entry.is_empty()));
}
