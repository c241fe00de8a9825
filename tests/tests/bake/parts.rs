//! Parts of a bake, and how many threads make it: the same bytes.

use std::path::Path;

use dsm_core::{Filter, FilterShape, Progress, Rgb, Transmittance};
use dsm_io::MergeReport;
use dsm_io::detail::{BakeOptions, Crop};

use crate::support::{Stage, open};

const SIZE: [u32; 2] = [44, 36];

/// Parts of a map of that size in tiles of 16, which cover it once.
const PARTS: [[u32; 4]; 4] = [[0, 0, 32, 16], [32, 0, 44, 36], [0, 16, 32, 32], [0, 32, 32, 36]];

fn bytes(path: &Path) -> Vec<u8> {
    std::fs::read(path).unwrap()
}

fn check<T: Transmittance>(stage: &Stage, filter: Filter) {
    let folder = tempfile::tempdir().unwrap();
    let whole = folder.path().join("whole.dsm");
    let options = BakeOptions::default();
    let settings = stage.settings(SIZE).with_tile_size(16).with_filter(filter);
    stage.bake_as::<T>(&settings, &options, &whole);
    let reader = open(&whole);
    assert_eq!(reader.crop(), None);
    assert!(reader.directory(0).unwrap().iter().any(|(_, entry)| !entry.is_empty()));

    for threads in [1, 4] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let again = folder.path().join("again.dsm");
        pool.install(|| stage.bake_as::<T>(&settings, &options, &again));
        assert!(bytes(&again) == bytes(&whole), "other bytes on {threads} threads");
    }

    let crops = PARTS.iter().enumerate().map(|(index, &part)| {
        let path = folder.path().join(format!("part{index}.dsm"));
        let settings = settings.clone().with_crop(part);
        stage.bake_as::<T>(&settings, &options, &path);
        let reader = open(&path);
        let [x, y, right, bottom] = part;
        assert_eq!(reader.crop(), Some(Crop { x, y, width: right - x, height: bottom - y }));
        assert_eq!(reader.whole_metadata().width, SIZE[0]);
        reader
    });
    // In another order than that of the whole.
    let crops: Vec<_> = crops.collect::<Vec<_>>().into_iter().rev().collect();
    let merged = folder.path().join("merged.dsm");
    let report = dsm_io::merge(&crops, &merged, None, Progress::ignore).unwrap();
    assert_eq!(report, MergeReport::Assembled);
    assert!(bytes(&merged) == bytes(&whole), "the parts are not the whole");
}

fn filter(shape: FilterShape, width: f32) -> Filter {
    Filter::new(shape, width).unwrap()
}

#[test]
fn of_moving_surfaces() {
    let stage = Stage::builtin("spinning-sphere");
    check::<f32>(&stage, filter(FilterShape::Box, 1.0));
    check::<f32>(&stage, filter(FilterShape::Gaussian, 3.0));
}

#[test]
fn of_media() {
    let stage = Stage::builtin("pipes");
    check::<f32>(&stage, filter(FilterShape::Box, 1.0));
    check::<f32>(&stage, filter(FilterShape::Gaussian, 3.0));
}

#[test]
fn of_coloured_surfaces() {
    let stage = Stage::builtin("stained-glass");
    check::<Rgb>(&stage, filter(FilterShape::Box, 1.0));
    check::<Rgb>(&stage, filter(FilterShape::Gaussian, 3.0));
}
