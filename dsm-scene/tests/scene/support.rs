//! What the tests share.

use std::path::PathBuf;

pub(crate) use dsm_testkit::{config, is_long};

/// A real file, or `None` with a note where there are none.
pub(crate) fn real_file(name: &str) -> Option<PathBuf> {
    let path = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data")).join(name);
    if path.exists() {
        return Some(path);
    }
    println!("SKIPPED: {} is not there", path.display());
    None
}
