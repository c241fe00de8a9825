//! Cameras as dicts of matrices.

use deepshadow::visibility::ShadowCamera;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays;
use crate::error::{Failure, Result};

const NAMES: [&str; 2] = ["world_to_camera", "world_to_ndc"];

/// A camera's matrices, for column vectors; `None` for one that is unknown.
pub(crate) fn to_dict(py: Python<'_>, camera: ShadowCamera) -> Result<Bound<'_, PyDict>> {
    let dict = PyDict::new(py);
    for (name, known) in NAMES.into_iter().zip([camera.world_to_camera, camera.world_to_ndc]) {
        dict.set_item(name, known.map(|known| arrays::matrix(py, known)).transpose()?)?;
    }
    Ok(dict)
}

/// The camera of a dict such as [`to_dict`] makes.
pub(crate) fn from_dict(given: &Bound<'_, PyAny>) -> Result<ShadowCamera> {
    let dict = given.cast::<PyDict>().map_err(PyErr::from)?;
    if let Some(other) = dict
        .keys()
        .iter()
        .find(|name| name.extract::<String>().map_or(true, |name| !NAMES.contains(&name.as_str())))
    {
        let [camera, ndc] = NAMES;
        return Err(Failure::setting(format!("a camera has {camera} and {ndc}, no {other}")));
    }
    let read = |name: &str| -> Result<_> {
        let given = dict.get_item(name)?.filter(|given| !given.is_none());
        given.map(|given| arrays::read_matrix(&given)).transpose()
    };
    Ok(ShadowCamera { world_to_camera: read(NAMES[0])?, world_to_ndc: read(NAMES[1])? })
}
