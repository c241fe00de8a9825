//! The files that once broke OpenEXR itself: each is an error or an answer,
//! soon, in little memory, and without a panic. Alone in its program, so that
//! its peak of memory can be measured.

use std::path::Path;
use std::time::{Duration, Instant};

use deep_exr::{DeepExrReader, Error, Limits};

const FOLDER: &str = "../../shared/data/deep/damaged";

fn read(path: &Path) -> Result<usize, Error> {
    let mut reader = DeepExrReader::open(path, None, &Limits::default())?;
    let height = reader.header().height;
    let mut samples = 0;
    for first in (0..height).step_by(64) {
        samples += reader.read_rows(first..height.min(first + 64))?.sample_count();
    }
    Ok(samples)
}

/// Peak memory of this process in bytes, where the system tells.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix(" kB")?.parse::<u64>().ok().map(|kibibytes| 1024 * kibibytes)
}

#[test]
fn damaged_files_fail_soon_and_in_little_memory() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(FOLDER);
    let Ok(entries) = std::fs::read_dir(&folder) else {
        eprintln!("skipped: no folder {FOLDER}");
        return;
    };
    let mut read_files = 0;
    for path in entries.map(|entry| entry.unwrap().path()) {
        let start = Instant::now();
        let result = read(&path);
        let elapsed = start.elapsed();
        eprintln!("{:?}: {result:?}", path.file_name().unwrap());
        assert!(elapsed < Duration::from_secs(2), "{path:?} took {elapsed:?}");
        read_files += 1;
    }
    assert!(read_files >= 15, "{read_files} files");
    if let Some(peak) = peak_memory() {
        assert!(peak < 256 << 20, "{peak} bytes");
    }
}
