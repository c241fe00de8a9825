//! What the files are: the same bytes always, level 0 untouched, whatever was
//! above it replaced.

use std::fs;
use std::path::Path;

use dsm_core::detail::PixelLists;
use dsm_core::{MapInfo, Progress, Rgb, Transmittance};
use dsm_io::detail::{Level, MapWriter, TileId};
use dsm_io::{AchievedError, MapReader, Metadata, Packing, PyramidOptions, WriteOptions, mip};

use crate::maps::{Content, Shape, open, pixels, write};

const CONTENT: Content = Content { seed: 1, on_grid: true, empty: 8 };

fn build(input: &Path, output: &Path, options: &PyramidOptions) {
    mip(&open(input), output, options, Progress::ignore).unwrap();
}

fn same_bytes_with_any_number_of_threads<T: Transmittance>(shape: &Shape) {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    write(&path("flat.dsm"), shape, &pixels::<T>(shape.size, CONTENT));
    let bytes = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| build(&path("flat.dsm"), &path("pyramid.dsm"), &shape.options));
        fs::read(path("pyramid.dsm")).unwrap()
    };
    let one = bytes(1);
    assert!(one == bytes(4) && one == bytes(3), "{shape:?}");
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let shape = Shape::new([150, 93], 8, 0.02);
    same_bytes_with_any_number_of_threads::<f32>(&shape);
    same_bytes_with_any_number_of_threads::<Rgb>(&Shape {
        packing: Packing::Zstd,
        tile: 6,
        ..shape
    });
}

#[test]
fn level_0_keeps_its_bytes_and_its_errors() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    for (packing, empty) in [(Packing::Plain, 8), (Packing::Zstd, 8), (Packing::Zstd, 16)] {
        let shape = Shape { packing, ..Shape::new([50, 20], 8, 0.02) };
        let content = Content { empty, ..CONTENT };
        write(&path("flat.dsm"), &shape, &pixels::<Rgb>(shape.size, content));
        build(&path("flat.dsm"), &path("pyramid.dsm"), &shape.options);
        let (flat, pyramid) = (open(&path("flat.dsm")), open(&path("pyramid.dsm")));
        assert_eq!(flat.metadata(), pyramid.metadata());
        assert_eq!(flat.levels()[0], pyramid.levels()[0]);
        for (id, entry) in flat.directory(0).unwrap().iter() {
            let copy = pyramid.encoded_tile(id).unwrap();
            assert_eq!(flat.encoded_tile(id).unwrap(), copy);
            assert_eq!(copy.1, entry.error);
        }
        let blocks = (1..).zip(&pyramid.levels()[1..]).flat_map(|(index, _)| {
            pyramid.directory(index).unwrap().iter().map(|(_, entry)| entry.block)
        });
        let packed = blocks.filter(|&block| block != 0).count();
        assert_eq!(packed > 0, packing == Packing::Zstd && empty < 16);
    }
}

#[test]
fn a_pyramid_is_replaced_and_a_file_may_replace_itself() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let shape = Shape::new([40, 30], 8, 0.02);
    write(&path("map.dsm"), &shape, &pixels::<f32>(shape.size, CONTENT));
    build(&path("map.dsm"), &path("whole.dsm"), &shape.options);
    let whole = fs::read(path("whole.dsm")).unwrap();
    for levels in [2, 1, 4] {
        build(&path("map.dsm"), &path("map.dsm"), &shape.options.with_levels(levels));
        assert_eq!(open(&path("map.dsm")).levels().len(), levels as usize);
    }
    let reader = open(&path("map.dsm"));
    mip(&reader, &path("map.dsm"), &shape.options, Progress::ignore).unwrap();
    // Whoever has the old one open still reads it.
    assert_eq!(reader.levels().len(), 4);
    assert!(reader.verify().is_empty());
    assert!(fs::read(path("map.dsm")).unwrap() == whole);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
}

#[test]
fn a_map_that_cannot_have_a_pyramid_is_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    let shape = Shape::new([9, 9], 4, 0.0);
    write(&path, &shape, &pixels::<f32>(shape.size, CONTENT));
    let before = fs::read(&path).unwrap();
    let refused = |options: PyramidOptions| {
        mip(&open(&path), &path, &options, Progress::ignore).unwrap_err().to_string()
    };
    let scaled = refused(shape.options.with_tolerance_scale(2.0));
    assert!(scaled.contains("a tolerance scale must lie in (0, 1], not 2"), "{scaled}");
    assert!(refused(shape.options.with_levels(0)).contains("at least one level"));
    assert!(fs::read(&path).unwrap() == before);

    let views = folder.path().join("views.dsm");
    let mut writer = MapWriter::create(&views, shape.metadata(1), shape.write_options()).unwrap();
    writer.add_level(Level { view: 1, ..Level::new(9, 9, 4, 0.0) }).unwrap();
    writer.finish().unwrap();
    let refused =
        mip(&open(&views), &path, &shape.options, Progress::ignore).unwrap_err().to_string();
    assert!(refused.contains("views.dsm: a map of several views"), "{refused}");
    assert!(fs::read(&path).unwrap() == before);
}

#[test]
fn an_empty_map_has_empty_levels() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    let metadata = Metadata::new(100, 70, 1, MapInfo::default());
    let options = WriteOptions::default().with_tile_size(16);
    let mut writer = MapWriter::create(&path, metadata, options).unwrap();
    // A tile without vertices may have an error: what it stood for had some.
    let error = AchievedError { max: 1e-7, mean: 1e-8 };
    let id = TileId::new(0, 3, 2);
    writer.write_tile(id, PixelLists::<f32>::clear(16, 16).view(), error).unwrap();
    writer.finish().unwrap();
    build(&path, &path, &PyramidOptions::default());
    let reader = open(&path);
    assert_eq!(reader.levels().len(), 8);
    assert_eq!(reader.directory(0).unwrap().get(3, 2).map(|entry| entry.error), Some(error));
    for (index, level) in (1..).zip(&reader.levels()[1..]) {
        assert_eq!(level.error, AchievedError::NONE);
        assert!(reader.directory(index).unwrap().iter().all(|(_, entry)| entry.is_empty()));
    }
    assert!(reader.verify().is_empty());
}

#[test]
fn a_damaged_tile_is_an_error_and_the_old_file_stays() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    let shape = Shape::new([20, 20], 8, 0.0);
    write(&path, &shape, &pixels::<f32>(shape.size, Content { empty: 0, ..CONTENT }));
    let mut bytes = fs::read(&path).unwrap();
    bytes[70] ^= 1;
    let reader = MapReader::from_bytes(bytes, &dsm_io::Limits::default()).unwrap();
    let before = fs::read(&path).unwrap();
    let refused = mip(&reader, &path, &shape.options, Progress::ignore).unwrap_err().to_string();
    assert!(
        refused.contains("tile (0, 0) of level 0") && refused.contains("checksum"),
        "{refused}"
    );
    assert!(fs::read(&path).unwrap() == before);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}
