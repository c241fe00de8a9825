//! How property tests run.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// The same cases in every run: 256, or 20,000 with `DSM_LONG_TESTS` set.
pub(crate) fn config(seed: u64) -> ProptestConfig {
    let long = std::env::var_os("DSM_LONG_TESTS").is_some_and(|value| value == "1");
    ProptestConfig {
        cases: if long { 20_000 } else { 256 },
        rng_seed: RngSeed::Fixed(seed),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}
