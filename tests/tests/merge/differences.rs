//! How far maps are apart, level by level.

use std::path::Path;

use dsm_core::detail::{PixelLists, VisibilityDifference};
use dsm_core::{MapInfo, Progress, Rgb, Vertex};
use dsm_io::detail::{Level, MapDifference, MapWriter, TileId, compare, compare_levels};
use dsm_io::{
    AchievedError, ConvertOptions, Limits, MapReader, MapSource, Metadata, Packing, WriteOptions,
    convert,
};

use super::{image, info, metadata, source, write};
use crate::pixels::build;

/// Pixels that let `light` through behind depth 2, but `other` at (x, y).
fn pixels(size: [u32; 2], light: f32, [x, y]: [u32; 2], other: f32) -> PixelLists<f32> {
    let all = (0..size[1]).flat_map(|j| (0..size[0]).map(move |i| [i, j]));
    build(
        size[0],
        size[1],
        all.map(|place| {
            let light = if place == [x, y] { other } else { light };
            if light == 1.0 {
                Vec::new()
            } else {
                vec![Vertex::new(2.0, 1.0), Vertex::new(2.0, light)]
            }
        }),
    )
}

/// A map of these levels, one tile each.
fn pyramid(path: &Path, levels: &[PixelLists<f32>]) -> MapSource {
    let options = WriteOptions::default();
    let mut writer = MapWriter::create(path, metadata(&levels[0], info(0.0)), options).unwrap();
    for (number, pixels) in (1..).zip(&levels[1..]) {
        let level = Level::new(pixels.view().width(), pixels.view().height(), 64, 0.0);
        writer.add_level(Level { number, ..level }).unwrap();
    }
    for (level, pixels) in (0..).zip(levels) {
        let id = TileId::new(level, 0, 0);
        writer.write_tile(id, pixels.view(), AchievedError::NONE).unwrap();
    }
    writer.finish().unwrap();
    source(path)
}

fn differ(a: &mut MapSource, b: &mut MapSource) -> dsm_io::detail::Result<MapDifference> {
    let mut told = (0, 0);
    let difference = compare_levels(a, b, |rows| {
        assert!(rows.done >= told.0 && rows.done <= rows.total);
        told = (rows.done, rows.total);
        Progress::ignore(rows)
    });
    assert!(difference.is_err() || told.0 == told.1, "{told:?}");
    difference
}

#[test]
fn the_worst_of_all_common_levels_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let fine = pixels([4, 4], 0.5, [0, 0], 0.5);
    let coarse = pixels([2, 2], 0.5, [0, 0], 0.5);
    let point = pixels([1, 1], 0.5, [0, 0], 0.0);
    let mut a = pyramid(&folder.path().join("a.dsm"), &[fine, coarse.clone(), point]);
    let off = pixels([4, 4], 0.5, [3, 1], 0.75);
    let further_off = pixels([2, 2], 0.5, [1, 1], 1.0);
    let mut b = pyramid(&folder.path().join("b.dsm"), &[off.clone(), further_off]);
    let difference = differ(&mut a, &mut b).unwrap();
    let worst = difference.worst.unwrap();
    assert_eq!((worst.level, worst.x, worst.y, worst.z), (1, 1, 1, 2.0));
    assert_eq!((worst.channel, difference.max()), (0, 0.5));
    // At one depth the mean is that of both sides: 1/8 and 1/4 of 20 pixels.
    assert_eq!(difference.mean, (0.125 + 0.25) / 20.0);
    // The first of equals, and level 0 alone for who asks for that.
    let mut c = pyramid(&folder.path().join("c.dsm"), &[off, coarse]);
    let worst = differ(&mut a, &mut c).unwrap().worst.unwrap();
    assert_eq!((worst.level, worst.x, worst.y, worst.difference), (0, 3, 1, 0.25));
    assert_eq!(compare(&mut a, &mut b, Progress::ignore).unwrap().max(), 0.25);
}

#[test]
fn tiles_and_blocks_make_no_difference() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let pixels = pixels([23, 17], 1.0, [7, 9], 0.25);
    for (one, other) in [(1, 3), (4, 4), (5, 16), (64, 2)] {
        let of = |tile| WriteOptions::default().with_tile_size(tile);
        write(&path("a.dsm"), &pixels, info(0.0), of(one));
        write(&path("b.dsm"), &pixels, info(0.0), of(other).with_packing(Packing::Zstd));
        let none = super::pixels::build(23, 17, (0..23 * 17).map(|_| Vec::<Vertex<f32>>::new()));
        write(&path("none.dsm"), &none, info(0.0), of(other));
        let [mut a, mut b, mut none] =
            ["a.dsm", "b.dsm", "none.dsm"].map(|name| source(&path(name)));
        assert_eq!(differ(&mut a, &mut b).unwrap(), MapDifference::default());
        for (one, other) in [(&mut a, &mut none), (&mut b, &mut source(&path("none.dsm")))] {
            let worst = differ(one, other).unwrap().worst.unwrap();
            assert_eq!((worst.x, worst.y, worst.difference), (7, 9, 0.75));
        }
    }
}

/// The sums are those of comparing pixel by pixel, with any number of threads.
#[test]
fn the_mean_is_over_all_pixels() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let sample = image("docs/sample/tuft.exr");
    let converted = |name: &str, epsilon: f32, tile| {
        let options = ConvertOptions {
            tolerance: info(epsilon).tolerance,
            write: WriteOptions::default().with_tile_size(tile),
            ..ConvertOptions::default()
        };
        convert(&mut source(&sample), &path(name), &options, Progress::ignore).unwrap();
    };
    converted("a.dsm", 0.0, 16);
    converted("b.dsm", 0.1, 7);
    let differences = [1, 4].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| differ(&mut source(&path("a.dsm")), &mut source(&path("b.dsm"))).unwrap())
    });
    assert_eq!(differences[0], differences[1]);
    let read = |name: &str| {
        let reader = MapReader::open(path(name), &Limits::default()).unwrap();
        reader.read_map::<f32>(0).unwrap()
    };
    let (a, b) = (read("a.dsm"), read("b.dsm"));
    let pixels = (0..48).flat_map(|y| (0..48).map(move |x| (x, y)));
    let (mut max, mut sum) = (0.0_f64, 0.0);
    for (x, y) in pixels {
        let difference = VisibilityDifference::between(&a.pixel(x, y), &b.pixel(x, y));
        max = max.max(difference.max());
        sum += difference.mean();
    }
    assert!(max > 0.01);
    assert_eq!(differences[0].max(), max);
    assert!((differences[0].mean - sum / (48.0 * 48.0)).abs() < 1e-12);
    // An image beside a map is compared row by row, to the same end.
    let of_image = differ(&mut source(&sample), &mut source(&path("b.dsm"))).unwrap();
    assert!((of_image.max() - max).abs() < 2e-6);
    assert!((of_image.mean - differences[0].mean).abs() < 1e-6);
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let clear = |size| pixels(size, 1.0, [0, 0], 1.0);
    let refused = |a: &mut MapSource, b: &mut MapSource| differ(a, b).unwrap_err().to_string();
    let mut a = pyramid(&path("a.dsm"), &[clear([4, 4]), clear([2, 2])]);
    let mut b = pyramid(&path("b.dsm"), &[clear([4, 3])]);
    let mut c = pyramid(&path("c.dsm"), &[clear([4, 4]), clear([2, 1])]);
    assert_eq!(refused(&mut a, &mut b), "the sizes differ: 4 × 4 and 4 × 3 pixels");
    let level = refused(&mut a, &mut c);
    assert_eq!(level, "the sizes of level 1 differ: 2 × 2 and 2 × 1 pixels");
    let colour = build(4, 4, (0..16).map(|_| Vec::<Vertex<Rgb>>::new()));
    write(&path("d.dsm"), &colour, info(0.0), WriteOptions::default());
    let channels = refused(&mut a, &mut source(&path("d.dsm")));
    assert_eq!(channels, "the numbers of channels differ: 1 and 3");
    let mut crops = [0, 4].map(|x| {
        let whole = Metadata::new(8, 4, 1, MapInfo::default());
        let crop = dsm_io::detail::Crop { x, y: 0, width: 4, height: 4 };
        let options = WriteOptions::default().with_tile_size(4);
        let writer = MapWriter::create_crop(path("e.dsm"), whole, crop, options).unwrap();
        writer.finish().unwrap();
        source(&path("e.dsm"))
    });
    let [one, other] = &mut crops;
    assert_eq!(refused(one, other), "they are other parts of a map");
    assert_eq!(differ(one, &mut source(&path("a.dsm"))).unwrap().max(), 0.0);
}

#[test]
fn empty_tiles_cost_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let map = |name: &str| {
        let path = folder.path().join(name);
        let options = WriteOptions::default().with_tile_size(1 << 22);
        let metadata = Metadata::new(1 << 30, 1 << 30, 1, MapInfo::default());
        MapWriter::create(&path, metadata, options).unwrap().finish().unwrap();
        MapSource::Map(Box::new(MapReader::open(&path, &Limits::default()).unwrap()))
    };
    let difference = differ(&mut map("a.dsm"), &mut map("b.dsm")).unwrap();
    assert_eq!(difference, MapDifference::default());
}
