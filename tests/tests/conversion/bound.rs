//! A map must keep the bound that it states, whatever its checksums say.

use std::path::Path;

use dsm_core::{DeepMap, PixelListsBuilder, Progress, Vertex};
use dsm_io::detail::{check_bound, compare};
use dsm_io::{AchievedError, Error, Limits, MapReader, WriteOptions, write_map};

use super::{converted, image, open, options};

const EPSILON: f32 = 0.02;
const IMAGE: &str = "scan_none_float.exr";

fn reader(path: &Path) -> MapReader {
    MapReader::open(path, &Limits::default()).unwrap()
}

/// A map that states ε and claims to have no error, all of whose values but
/// the first of each pixel are `offset` too low.
fn map_off_by(offset: f32, folder: &Path) -> MapReader {
    let exact = reader(&converted(&image(IMAGE), folder, &options(0.0, 64)));
    let map = exact.read_map::<f32>(0).unwrap();
    let pixels = map.pixels().view();
    let mut darker = PixelListsBuilder::<f32>::new(pixels.width(), pixels.height());
    for function in pixels.functions() {
        for (index, vertex) in function.vertices().enumerate() {
            let value = if index == 0 { 1.0 } else { (vertex.value - offset).max(0.0) };
            darker.push(Vertex::new(vertex.z, value));
        }
        darker.finish_pixel().unwrap();
    }
    let stated = options(EPSILON, 64).tolerance;
    let mut metadata = exact.metadata().clone();
    metadata.info.tolerance = stated;
    let map = DeepMap::new(metadata.info, darker.finish().unwrap());
    let path = folder.join("darker.dsm");
    write_map(&path, metadata, &map, AchievedError::NONE, WriteOptions::default()).unwrap();
    let reader = reader(&path);
    assert!(reader.verify().is_empty());
    reader
}

#[test]
fn a_map_off_by_more_than_its_tolerance_is_found_out() {
    let folder = tempfile::tempdir().unwrap();
    let map = map_off_by(1.1 * EPSILON, folder.path());
    let error = check_bound(map, &mut open(&image(IMAGE)), Progress::ignore).unwrap_err();
    let Error::Bound { stated, worst } = error else { panic!("{error}") };
    assert_eq!(stated, EPSILON);
    assert!((worst.difference - 1.1 * f64::from(EPSILON)).abs() < 1e-6, "{worst:?}");
}

#[test]
fn a_map_off_by_less_than_its_tolerance_keeps_it() {
    let folder = tempfile::tempdir().unwrap();
    let map = map_off_by(0.9 * EPSILON, folder.path());
    let difference = check_bound(map, &mut open(&image(IMAGE)), Progress::ignore).unwrap();
    assert!((difference.max() - 0.9 * f64::from(EPSILON)).abs() < 1e-6);
    assert!(difference.mean > 0.0 && difference.mean <= difference.max());
}

#[test]
fn every_converted_map_keeps_its_bound() {
    let folder = tempfile::tempdir().unwrap();
    for name in super::IMAGES {
        for epsilon in [0.0, 1e-7, 1e-5, 0.003, 0.3] {
            let path = converted(&image(name), folder.path(), &options(epsilon, 3));
            check_bound(reader(&path), &mut open(&image(name)), Progress::ignore).unwrap();
        }
    }
}

#[test]
fn maps_of_different_sizes_are_not_compared() {
    let (a, b) = (image("scan_zips_half.exr"), image("parts.exr"));
    assert!(matches!(
        compare(&mut open(&a), &mut open(&b), Progress::ignore),
        Err(Error::Mismatch(_))
    ));
}
