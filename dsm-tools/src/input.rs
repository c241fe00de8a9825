//! Files that commands read: by name, or what comes in by standard input as `-`.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use tempfile::NamedTempFile;

/// The name of standard input and output.
pub(crate) const STREAM: &str = "-";

/// A file to read. Maps and images are read from many places at once, so that what a pipe brings
/// stands in a temporary file as long as this is held.
pub(crate) struct Input {
    path: PathBuf,
    /// What it is called in messages and pages.
    name: String,
    _spooled: Option<NamedTempFile>,
}

impl Input {
    pub(crate) fn new(path: &Path) -> Result<Self> {
        if path.as_os_str() != STREAM {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            return Ok(Self { path: path.to_owned(), name, _spooled: None });
        }
        let mut spooled = NamedTempFile::new().context("no file for what comes in")?;
        io::copy(&mut io::stdin().lock(), &mut spooled).context("reading standard input")?;
        spooled.flush().context("keeping what comes in")?;
        let path = spooled.path().to_owned();
        Ok(Self { path, name: "standard input".to_owned(), _spooled: Some(spooled) })
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    pub(crate) fn name(&self) -> &str {
        &self.name
    }
}
