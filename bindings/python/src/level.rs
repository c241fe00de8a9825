//! Levels of a map.

use deepshadow::files::detail::Level as StoredLevel;
use pyo3::prelude::*;

/// A level of a map, an array of pixels.
#[pyclass(frozen, get_all, module = "deepshadow")]
#[derive(Clone, Debug)]
pub(crate) struct Level {
    /// Number of the view that the level belongs to, from 0.
    view: u32,
    /// Number within the view: 0 is the finest.
    number: u32,
    /// Rows and columns of pixels, as numpy has them.
    shape: (u32, u32),
    /// Column and row of the first pixel in pixels of the view.
    origin: (i32, i32),
    /// Rows and columns of a tile.
    tile_shape: (u32, u32),
    /// Bound of the error of every visibility function, in [0, 1).
    tolerance: f32,
    /// Largest error of any function, in [0, 1].
    max_error: f32,
    /// Mean error over all pixels, in [0, 1].
    mean_error: f32,
}

impl From<&StoredLevel> for Level {
    fn from(level: &StoredLevel) -> Self {
        Self {
            view: level.view,
            number: level.number,
            shape: (level.height, level.width),
            origin: (level.x, level.y),
            tile_shape: (level.tile_height, level.tile_width),
            tolerance: level.tolerance,
            max_error: level.error.max,
            mean_error: level.error.mean,
        }
    }
}

#[pymethods]
impl Level {
    fn __repr__(&self) -> String {
        let ((rows, columns), Self { number, tolerance, .. }) = (self.shape, self);
        format!("<deepshadow.Level {number}: {rows} x {columns}, tolerance {tolerance}>")
    }
}
