//! Deep images in memory.

use deepshadow::files::Attribute;
use deepshadow::files::deep_exr::detail::Alpha;
use deepshadow::files::deep_exr::{DeepRows, Header, Window};
use deepshadow::glam::DMat4;
use deepshadow::visibility::ShadowCamera;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::Result;
use crate::{arrays, attributes, camera};

/// A deep image in ragged columns, as read_deep_exr() reads it. The samples of pixel i,
/// counted row by row, are offsets[i] to offsets[i + 1]; in the file's order, values as they
/// are in the file. The columns are read-only numpy arrays.
#[pyclass(frozen, module = "deepshadow")]
pub(crate) struct DeepImage {
    header: Header,
    offsets: Py<PyAny>,
    z: Py<PyAny>,
    back: Option<Py<PyAny>>,
    alpha: Option<Py<PyAny>>,
}

impl DeepImage {
    /// The rows of a whole image. Of one opacity a sample nothing is copied.
    pub(crate) fn new(py: Python<'_>, header: Header, rows: DeepRows) -> Result<Self> {
        let (offsets, z, back, alpha) = rows.into_columns();
        let alpha = match alpha {
            Alpha::Opaque => None,
            Alpha::Mono(alpha) => Some(arrays::column(py, alpha).unbind()),
            Alpha::Colour([red, green, blue]) => {
                let colours = red.iter().zip(&green).zip(&blue);
                let flat = colours.flat_map(|((&red, &green), &blue)| [red, green, blue]).collect();
                Some(arrays::rows(py, flat, 3)?.unbind())
            }
        };
        Ok(Self {
            header,
            offsets: arrays::column(py, offsets).unbind(),
            z: arrays::column(py, z).unbind(),
            back: back.map(|back| arrays::column(py, back).unbind()),
            alpha,
        })
    }
}

/// Left, top, right, bottom, the last two inclusive, as OpenEXR has them.
fn edges(window: Window) -> [i32; 4] {
    let ([left, top], [right, bottom]) = (window.min, window.max);
    [left, top, right, bottom]
}

#[pymethods]
impl DeepImage {
    /// First sample of each pixel, and the end: (pixels + 1,) uint32.
    #[getter]
    fn offsets(&self, py: Python<'_>) -> Py<PyAny> {
        self.offsets.clone_ref(py)
    }

    /// Front depths: (samples,) float32.
    #[getter]
    fn z(&self, py: Python<'_>) -> Py<PyAny> {
        self.z.clone_ref(py)
    }

    /// Back depths: (samples,) float32; None if the file has none.
    #[getter]
    fn zback(&self, py: Python<'_>) -> Option<Py<PyAny>> {
        self.back.as_ref().map(|back| back.clone_ref(py))
    }

    /// Opacities: (samples,) float32, of coloured ones (samples, 3); None if the file has
    /// none: every sample is opaque.
    #[getter]
    fn a(&self, py: Python<'_>) -> Option<Py<PyAny>> {
        self.alpha.as_ref().map(|alpha| alpha.clone_ref(py))
    }

    /// Rows and columns, in pixels.
    #[getter]
    const fn shape(&self) -> (u32, u32) {
        (self.header.height, self.header.width)
    }

    /// The pixels that are stored: left, top, right, bottom, all inclusive.
    #[getter]
    fn data_window(&self) -> [i32; 4] {
        edges(self.header.data_window)
    }

    /// The pixels of the whole picture: left, top, right, bottom, all inclusive.
    #[getter]
    fn display_window(&self) -> [i32; 4] {
        edges(self.header.display_window)
    }

    /// The name of the compression, such as "ZIPS".
    #[getter]
    const fn compression(&self) -> &'static str {
        self.header.compression
    }

    /// The names of all channels of the file.
    #[getter]
    fn channels(&self) -> Vec<&str> {
        self.header.channels.iter().map(|channel| channel.name.as_str()).collect()
    }

    /// The matrices of the header as they are in the file, but for column vectors: their
    /// conventions differ between programs. None if it has none.
    #[getter]
    fn camera<'py>(&self, py: Python<'py>) -> Result<Option<Bound<'py, PyDict>>> {
        let matrix = |numbers: Option<[f32; 16]>| {
            numbers.map(|numbers| DMat4::from_cols_array(&numbers.map(f64::from)))
        };
        let known = ShadowCamera {
            world_to_camera: matrix(self.header.world_to_camera),
            world_to_ndc: matrix(self.header.world_to_ndc),
        };
        let is_known = known.world_to_camera.or(known.world_to_ndc).is_some();
        is_known.then(|| camera::to_dict(py, known)).transpose()
    }

    /// All other attributes: strings, numbers, lists of numbers, bytes.
    #[getter]
    fn attrs<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyDict>> {
        let named: Vec<_> = self
            .header
            .attributes
            .iter()
            .map(|attribute| {
                let type_name = String::from_utf8_lossy(&attribute.type_name);
                (attribute.name_text(), Attribute::new(type_name, attribute.value.clone()))
            })
            .collect();
        attributes::to_dict(py, named.iter().map(|(name, value)| (&**name, value.clone())))
    }

    /// The image as an Awkward Array of type rows * columns * var * {"z": float32, …},
    /// without a copy. Needs the package awkward.
    fn to_awkward<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>> {
        let fields = PyDict::new(py);
        fields.set_item("z", &self.z)?;
        if let Some(back) = &self.back {
            fields.set_item("zback", back)?;
        }
        if let Some(alpha) = &self.alpha {
            fields.set_item("a", alpha)?;
        }
        let module = py.import("deepshadow._awkward")?;
        Ok(module.call_method1("image", (self.shape(), &self.offsets, fields))?)
    }

    fn __repr__(&self) -> String {
        let (rows, columns) = self.shape();
        format!("<deepshadow.DeepImage {rows} x {columns}, {}>", self.header.compression)
    }
}
