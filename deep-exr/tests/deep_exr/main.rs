//! Reading deep OpenEXR files: good, hostile and damaged ones.

#![expect(clippy::unwrap_used, reason = "a test that fails says where")]

mod assemble;
mod damaged;
mod good;
mod hostile;
mod recovered;

use std::path::PathBuf;

use deep_exr::{DeepExrReader, DeepRows, Error, Limits};

/// A small file beside the tests.
fn small(name: &str) -> Vec<u8> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name);
    std::fs::read(&path).unwrap()
}

/// Reads everything, in bands of `band` rows.
fn read_in_bands(bytes: &[u8], band: u32) -> Result<Vec<DeepRows>, Error> {
    let mut reader = DeepExrReader::from_bytes(bytes.to_vec(), None, &Limits::default())?;
    let height = reader.header().height;
    (0..height)
        .step_by(band as usize)
        .map(|first| reader.read_rows(first..height.min(first + band)))
        .collect()
}

fn read(bytes: &[u8]) -> Result<DeepRows, Error> {
    let mut reader = DeepExrReader::from_bytes(bytes.to_vec(), None, &Limits::default())?;
    let height = reader.header().height;
    reader.read_rows(0..height)
}
