//! From deep images to maps and back to the numbers: what a map made from an
//! image answers is the transmittance of the image's samples.

#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test may stop, and says when it was skipped"
)]

mod accuracy;
mod bound;
mod cameras;
mod export;
mod export_bound;
mod files;
mod interruption;

use std::path::{Path, PathBuf};

use dsm_core::Progress;
use dsm_core::Tolerance;
use dsm_io::{ConvertOptions, Limits, MapSource, convert};

/// The images that the repository carries and that can be read.
const IMAGES: [&str; 9] = [
    "flat_tile_piz.exr",
    "flat_zip.exr",
    "parts.exr",
    "scan_none_float.exr",
    "scan_rle_opaque.exr",
    "scan_zips_half.exr",
    "tile_none_float.exr",
    "tile_rle_other_names.exr",
    "tile_zips_ids.exr",
];

fn image(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../deep-exr/tests/data").join(name)
}

/// The matrix of an image whose camera space has z the other way.
fn z_turned(mut matrix: [f32; 16]) -> [f32; 16] {
    matrix.iter_mut().skip(2).step_by(4).for_each(|z| *z = -*z);
    matrix
}

fn open(path: &Path) -> MapSource {
    MapSource::open(path, None, &Limits::default()).unwrap()
}

fn options(epsilon: f32, tile_size: u32) -> ConvertOptions {
    let defaults = ConvertOptions::default();
    ConvertOptions {
        tolerance: Tolerance::new(epsilon).unwrap(),
        write: defaults.write.with_tile_size(tile_size),
        ..defaults
    }
}

/// Converts `input` to a map in `folder`.
fn converted(input: &Path, folder: &Path, options: &ConvertOptions) -> PathBuf {
    let output = folder.join("map.dsm");
    convert(&mut open(input), &output, options, Progress::ignore).unwrap();
    output
}
