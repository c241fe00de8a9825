//! Where a file's bytes come from.

pub(crate) mod mapped;
pub(crate) mod memory;

use std::fmt::Debug;
use std::fs::File;
use std::path::Path;

use crate::error::{Error, Result};

/// The bytes of a whole file, which never change.
pub trait Source: Debug + Send + Sync {
    /// All bytes, always the same.
    fn bytes(&self) -> &[u8];
}

/// Opens a regular file and tells its length. Anything else could block
/// (pipes) or has no length.
fn open_regular(path: &Path) -> Result<(File, u64)> {
    let metadata = path.metadata().map_err(Error::io("open"))?;
    if !metadata.is_file() {
        return Err(Error::NotDsm("not a regular file"));
    }
    let file = File::open(path).map_err(Error::io("open"))?;
    // The file that was opened, not the one that had the name before.
    let length = file.metadata().map_err(Error::io("open"))?.len();
    Ok((file, length))
}
