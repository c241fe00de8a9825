//! Reads all samples of a real deep image of 1024 × 576 pixels, opening
//! included. The answer is checked before anything is timed.

use std::path::PathBuf;
use std::sync::Arc;

use deep_exr::{DeepExrReader, DeepRows, Error, Limits};
use divan::Bencher;
use divan::counter::ItemsCount;

const FILE: &str = "../../shared/data/deep/Leaves.exr";
const SAMPLES: usize = 291_861;
const SUM_OF_Z: f64 = 60_942_199.353_897_095;

fn path() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(FILE)
}

#[expect(clippy::print_stderr, reason = "says why nothing is timed")]
fn main() {
    let Ok(bytes) = std::fs::read(path()) else {
        eprintln!("skipped: no file {FILE}");
        return;
    };
    match read_all(DeepExrReader::from_bytes(bytes, None, &Limits::default())) {
        Ok(rows) if is_right(&rows) => divan::main(),
        Ok(rows) => eprintln!("wrong answer: {} samples", rows.sample_count()),
        Err(error) => eprintln!("no answer: {error}"),
    }
}

fn is_right(rows: &DeepRows) -> bool {
    let sum: f64 = rows.z().iter().copied().map(f64::from).sum();
    rows.sample_count() == SAMPLES && (sum - SUM_OF_Z).abs() < 1e-3
}

fn read_all(reader: Result<DeepExrReader, Error>) -> Result<DeepRows, Error> {
    let mut reader = reader?;
    let height = reader.header().height;
    reader.read_rows(0..height)
}

#[divan::bench]
fn from_memory(bencher: Bencher<'_, '_>) {
    let bytes: Arc<[u8]> = std::fs::read(path()).unwrap_or_default().into();
    bencher
        .counter(ItemsCount::new(SAMPLES))
        .bench(|| read_all(DeepExrReader::from_bytes(bytes.clone(), None, &Limits::default())));
}

#[divan::bench]
fn from_file(bencher: Bencher<'_, '_>) {
    let path = path();
    bencher
        .counter(ItemsCount::new(SAMPLES))
        .bench(|| read_all(DeepExrReader::open(&path, None, &Limits::default())));
}
