//! Number of cases of a property test.

use proptest::test_runner::{Config, RngSeed};

/// True if tests run in the long mode: `DSM_LONG_TESTS=1`.
#[must_use]
pub fn is_long() -> bool {
    std::env::var_os("DSM_LONG_TESTS").is_some_and(|value| value == "1")
}

/// The configuration of property tests: 256 cases, 20,000 in the [long
/// mode](is_long), reproducible from this seed. Nothing is written beside the
/// sources.
#[must_use]
pub fn config(seed: u64) -> Config {
    Config {
        cases: if is_long() { 20_000 } else { 256 },
        rng_seed: RngSeed::Fixed(seed),
        failure_persistence: None,
        max_shrink_iters: 10_000,
        ..Config::default()
    }
}
