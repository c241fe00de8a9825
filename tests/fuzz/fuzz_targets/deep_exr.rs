//! See `dsm_tests::fuzz::deep_exr`.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    dsm_tests::fuzz::deep_exr(bytes);
});
