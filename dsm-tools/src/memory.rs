//! The memory that the program has held at most, and that of the machine.

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

/// Bytes that the machine, or the container that this runs in, has, where the system
/// tells.
fn of_machine() -> Option<u64> {
    let text = fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    let limits = ["/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"];
    let limits =
        limits.iter().filter_map(|path| fs::read_to_string(path).ok()?.trim().parse().ok());
    Some(limits.fold(kilobytes.checked_mul(1024)?, u64::min))
}

/// What a scene may take if nobody says: three quarters of the machine's memory, or any
/// amount where the system does not tell.
pub(crate) fn for_a_scene() -> u64 {
    of_machine().map_or(u64::MAX, |bytes| bytes / 4 * 3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(target_os = "linux")]
    fn a_scene_may_take_less_than_there_is() {
        let machine = of_machine().unwrap();
        assert!(machine > 1 << 24 && for_a_scene() < machine && for_a_scene() > machine / 2);
        assert!(peak().is_some_and(|bytes| bytes > 0 && bytes < machine));
    }
}
