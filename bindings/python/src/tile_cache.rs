//! Tile caches that maps share.

use deepshadow::OpenOptions;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::Result;

/// TileCache(bytes=1073741824)
/// --
///
/// Memory for the tiles of all maps that are opened with it, at most so many bytes.
#[pyclass(frozen, module = "deepshadow")]
#[derive(Clone, Debug)]
pub(crate) struct TileCache(OpenOptions);

impl TileCache {
    /// The options that open maps with this cache.
    pub(crate) const fn options(&self) -> &OpenOptions {
        &self.0
    }
}

#[pymethods]
impl TileCache {
    #[new]
    #[pyo3(signature = (bytes=1 << 30))]
    fn new(bytes: u64) -> Self {
        Self(OpenOptions::new().with_cache_bytes(bytes))
    }

    /// Counts so far: hits, misses, loads, evictions; and tiles and bytes that are kept.
    #[getter]
    fn statistics<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyDict>> {
        let counts = self.0.cache().statistics();
        let dict = PyDict::new(py);
        for (name, count) in [
            ("hits", counts.hits),
            ("misses", counts.misses),
            ("loads", counts.loads),
            ("evictions", counts.evictions),
            ("tiles", counts.tiles),
            ("bytes", counts.bytes),
            ("peak_bytes", counts.peak_bytes),
        ] {
            dict.set_item(name, count)?;
        }
        Ok(dict)
    }
}
