//! The view that a map is baked from.

use deepshadow::visibility::ViewRaster;
use numpy::{AllowTypeChange, PyArrayLike1};
use pyo3::prelude::*;

use crate::arrays;
use crate::error::{Failure, Result};

/// What a bake looks through: handed to through(view) of a source. Maps of area lights are
/// seen from behind the light.
#[pyclass(frozen, module = "deepshadow")]
#[derive(Clone, Copy, Debug)]
pub(crate) struct View(ViewRaster);

impl From<ViewRaster> for View {
    fn from(view: ViewRaster) -> Self {
        Self(view)
    }
}

#[pymethods]
impl View {
    /// Rows and columns in pixels.
    #[getter]
    fn shape(&self) -> (u32, u32) {
        let [width, height] = self.0.resolution();
        (height, width)
    }

    /// Where the camera stands, in the world.
    #[getter]
    fn eye(&self) -> [f64; 3] {
        self.0.eye().to_array()
    }

    /// Whether rays meet in the eye; else they are parallel.
    #[getter]
    fn perspective(&self) -> bool {
        self.0.is_perspective()
    }

    /// The directions to the right, upwards and back, one a row, in the world.
    #[getter]
    fn basis<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>> {
        arrays::rows(py, self.0.basis().to_cols_array().to_vec(), 3)
    }

    /// rays(x, y)
    /// --
    ///
    /// The rays through raster positions in pixels: origins and directions, (n, 3) float64. A
    /// direction goes one unit deep, so that origin + depth · direction is the point of the
    /// world at a depth.
    fn rays<'py>(
        &self,
        py: Python<'py>,
        x: PyArrayLike1<'py, f64, AllowTypeChange>,
        y: PyArrayLike1<'py, f64, AllowTypeChange>,
    ) -> Result<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let (x, y) = (x.as_array(), y.as_array());
        if x.len() != y.len() {
            return Err(Failure::setting("x and y are not of one length"));
        }
        let (mut origins, mut directions) = (Vec::new(), Vec::new());
        for (&x, &y) in x.iter().zip(y) {
            let ray = self.0.ray(x, y, 0.0);
            origins.extend(ray.origin().to_array());
            directions.extend(ray.direction().to_array());
        }
        Ok((arrays::rows(py, origins, 3)?, arrays::rows(py, directions, 3)?))
    }

    fn __repr__(&self) -> String {
        let ((rows, columns), [x, y, z]) = (self.shape(), self.eye());
        format!("<deepshadow.View: {rows} x {columns} from ({x}, {y}, {z})>")
    }
}
