//! The most memory that the program has held.

use std::fs;

/// Begins to watch again from what is held now, where the system can (Linux).
pub(crate) fn forget_peak() {
    // Without that the peak is that of all work so far, which is no failure.
    drop(fs::write("/proc/self/clear_refs", "5"));
}

/// The most bytes that were held since, where the system tells.
pub(crate) fn peak() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kilobytes.checked_mul(1024)
}
