//! What a file asks for is not what it gets: sizes are compared with the file
//! and with limits before memory is taken.

#![cfg(target_os = "linux")]

use std::process::Command;

use dsm_core::Rgb;
use dsm_io::{Limits, MapReader, Packing};
use dsm_tests::forge::Forge;

use crate::examples::coloured;

/// The most address space that this process ever had, in KiB: what was asked
/// for and never touched counts too.
fn peak() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmPeak:")).unwrap();
    line.trim().trim_end_matches(" kB").parse().unwrap()
}

/// Reads all that there is to read.
fn read(bytes: Vec<u8>) {
    if let Ok(reader) = MapReader::from_bytes(bytes, &Limits::default()) {
        drop(reader.verify());
        drop(reader.read_map::<Rgb>(0));
        drop(reader.read_map::<f32>(0));
    }
}

/// Set in the process that this test has for itself.
const ALONE: &str = "DSM_TEST_ALONE";

#[test]
fn numbers_of_2_to_the_60_take_no_memory() {
    if std::env::var_os(ALONE).is_none() {
        let name = "allocation::numbers_of_2_to_the_60_take_no_memory";
        let mut alone = Command::new(std::env::current_exe().unwrap());
        let output = alone.args([name, "--exact", "--nocapture"]).env(ALONE, "1").output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(String::from_utf8_lossy(&output.stdout).contains("1 passed"));
        return;
    }
    const MEBIBYTE: u64 = 1 << 10;
    let files = [Packing::Plain, Packing::Zstd].map(|packing| coloured(packing).bytes());
    // Whatever the libraries set up the first time.
    files.iter().for_each(|file| read(file.clone()));
    let before = peak();
    let mut changed = 0;
    for file in files {
        for at in (0..file.len() - 8).step_by(4) {
            let mut forge = Forge(file.clone());
            forge.put(at, (1_u64 << 60).to_le_bytes());
            read(forge.sign());
            changed += 1;
        }
    }
    let grown = peak() - before;
    assert!(changed > 1000, "{changed}");
    assert!(grown < 4 * MEBIBYTE, "{grown} KiB were asked for");
    // Memory that is asked for does show, but for what was reserved before.
    let asked = std::hint::black_box(Vec::<u8>::with_capacity(1 << 30));
    assert!(peak() - before >= 512 * MEBIBYTE, "{} bytes are not seen", asked.capacity());
}
