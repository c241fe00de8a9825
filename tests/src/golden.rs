//! Golden files: bytes that were written once and stay readable.

#![expect(clippy::unwrap_used, clippy::panic, reason = "only tests read golden files")]

use std::fs::OpenOptions;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

/// Where golden files of version 1 of the format lie.
#[must_use]
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data/dsm-1")
}

/// The golden file of this name. With `DSM_WRITE_GOLDEN` set, one that is missing is
/// written with the bytes that `now` makes; one that is there never is.
///
/// # Panics
///
/// If there is no such file.
pub fn file(name: &str, now: impl FnOnce() -> Vec<u8>) -> Vec<u8> {
    let path = folder().join(name);
    if std::env::var_os("DSM_WRITE_GOLDEN").is_some() {
        write_missing(&path, now);
    }
    std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Writes a file that is not there yet; whether it was not.
fn write_missing(path: &Path, now: impl FnOnce() -> Vec<u8>) -> bool {
    match OpenOptions::new().write(true).create_new(true).open(path) {
        Ok(mut file) => {
            file.write_all(&now()).unwrap();
            true
        }
        Err(error) if error.kind() == ErrorKind::AlreadyExists => false,
        Err(error) => panic!("{}: {error}", path.display()),
    }
}

#[cfg(test)]
#[test]
fn a_file_that_is_there_is_never_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("golden.dsm");
    assert!(write_missing(&path, || b"first".to_vec()));
    assert!(!write_missing(&path, || b"second".to_vec()));
    assert_eq!(std::fs::read(path).unwrap(), b"first");
}
