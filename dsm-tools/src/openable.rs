//! Files that are shown as maps: maps, and images as maps that are made of them.

use std::ops::ControlFlow;
use std::path::Path;

use anyhow::{Context, Result};
use deepshadow::ShadowMap;
use deepshadow::files::{ConvertOptions, Limits, MapSource, convert};
use deepshadow::visibility::Tolerance;
use tempfile::TempDir;

/// What smooth stretches of an image may be off as chords: what `convert` takes as well.
const IMAGE_TOLERANCE: f32 = 1e-5;

/// A map, or the map of an image as long as this is held.
pub(crate) struct Openable {
    map: ShadowMap,
    /// Where an image's map is.
    _folder: Option<TempDir>,
}

impl Openable {
    /// Opens a map, or makes one of an image as `convert` does.
    pub(crate) fn open(path: &Path) -> Result<Self> {
        if !is_openexr(path) {
            return Ok(Self { map: ShadowMap::open(path)?, _folder: None });
        }
        let mut source = MapSource::open(path, None, &Limits::default())?;
        let folder = tempfile::tempdir().context("no folder for temporary files")?;
        let made = folder.path().join("image.dsm");
        let tolerance = Tolerance::new(IMAGE_TOLERANCE)?;
        let options = ConvertOptions { tolerance, ..ConvertOptions::default() };
        convert(&mut source, &made, &options, |_| ControlFlow::Continue(()))
            .with_context(|| format!("reading {}", path.display()))?;
        Ok(Self { map: ShadowMap::open(&made)?, _folder: Some(folder) })
    }

    pub(crate) const fn map(&self) -> &ShadowMap {
        &self.map
    }
}

/// True if a file begins as OpenEXRs do. One that cannot be read does not.
pub(crate) fn is_openexr(path: &Path) -> bool {
    use std::io::Read;

    const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
    // A pipe may never answer.
    if !path.is_file() {
        return false;
    }
    let mut first = [0; 4];
    std::fs::File::open(path).and_then(|mut file| file.read_exact(&mut first)).is_ok()
        && first == MAGIC
}
