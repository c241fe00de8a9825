//! What the tests share.

use std::path::PathBuf;

use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// Whether `DSM_LONG_TESTS` asks for many cases.
pub(crate) fn is_long() -> bool {
    std::env::var_os("DSM_LONG_TESTS").is_some_and(|value| value == "1")
}

/// The same cases in every run: 256, or 20,000 in long tests.
pub(crate) fn config(seed: u64) -> ProptestConfig {
    ProptestConfig {
        cases: if is_long() { 20_000 } else { 256 },
        rng_seed: RngSeed::Fixed(seed),
        failure_persistence: None,
        max_shrink_iters: 10_000,
        ..ProptestConfig::default()
    }
}

/// A real file, or `None` with a note where there are none.
pub(crate) fn real_file(name: &str) -> Option<PathBuf> {
    let path = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data")).join(name);
    if path.exists() {
        return Some(path);
    }
    println!("SKIPPED: {} is not there", path.display());
    None
}
