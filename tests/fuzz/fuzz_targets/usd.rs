//! See `dsm_tests::fuzz::usd`.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    dsm_tests::fuzz::usd(bytes);
});
