//! Several maps into one, and how far two are apart.

#![expect(clippy::unwrap_used, reason = "a test may stop where a file is refused")]

mod crops;
mod differences;
mod kinds;
#[path = "../format/pixels.rs"]
mod pixels;
mod products;
mod windows;

use std::path::{Path, PathBuf};

use dsm_core::detail::PixelLists;
use dsm_core::{DeepMap, MapInfo, Progress, Tolerance, Transmittance};
use dsm_io::{
    AchievedError, Limits, MapReader, MapSource, MergeReport, Metadata, WriteOptions, write_map,
};

fn info(epsilon: f32) -> MapInfo {
    MapInfo::new().with_tolerance(Tolerance::new(epsilon).unwrap())
}

fn metadata<T: Transmittance>(pixels: &PixelLists<T>, info: MapInfo) -> Metadata {
    let view = pixels.view();
    Metadata::new(view.width(), view.height(), T::CHANNELS as u8, info)
}

/// A map of these pixels; its tiles' error is half of its tolerance.
fn write<T: Transmittance>(
    path: &Path,
    pixels: &PixelLists<T>,
    info: MapInfo,
    options: WriteOptions,
) -> MapReader {
    let error = AchievedError { max: info.tolerance.epsilon() / 2.0, mean: 0.0 };
    let map = DeepMap::new(info, pixels.clone());
    write_map(path, metadata(pixels, info), &map, error, options).unwrap();
    open(path)
}

fn open(path: &Path) -> MapReader {
    let reader = MapReader::open(path, &Limits::default()).unwrap();
    assert!(reader.verify().is_empty(), "{:?}", reader.verify());
    reader
}

fn source(path: &Path) -> MapSource {
    MapSource::open(path, None, &Limits::default()).unwrap()
}

fn image(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(name)
}

/// Merges and says why that was refused.
#[track_caller]
fn refusal(maps: &[MapReader], tolerance: Option<Tolerance>) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("merged.dsm");
    let refused = dsm_io::merge(maps, &path, tolerance, Progress::ignore).unwrap_err();
    assert!(!path.exists());
    refused.to_string()
}

fn merge(maps: &[MapReader], path: &Path, epsilon: f32) -> MergeReport {
    let tolerance = (epsilon > 0.0).then(|| Tolerance::new(epsilon).unwrap());
    dsm_io::merge(maps, path, tolerance, Progress::ignore).unwrap()
}
