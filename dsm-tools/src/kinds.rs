//! The kinds of maps that the program knows.

use std::path::Path;

use dsm_io::{ErasedMap, Kinds, Limits};
use mtsm::{Layers, Mtsm};
use shadow_maps::fragments::Fragments;

/// All of them.
pub(crate) fn kinds() -> Kinds {
    Kinds::default().with::<Fragments>().with::<Layers>().with::<Mtsm>()
}

/// Opens a map of any of them.
pub(crate) fn open(path: &Path) -> dsm_io::Result<Box<dyn ErasedMap>> {
    kinds().open(path, &Limits::default())
}

/// Where an open map lies, for messages.
pub(crate) fn name(map: &dyn ErasedMap) -> String {
    map.container().path().unwrap_or(Path::new("")).display().to_string()
}
