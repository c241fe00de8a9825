//! Numpy arrays that nobody writes to.

use deepshadow::glam::DMat4;
use numpy::{
    AllowTypeChange, Element, PyArray1, PyArray2, PyArrayDescrMethods, PyArrayLike1,
    PyArrayMethods, PyReadwriteArray, PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use crate::error::{Failure, Result};

/// A read-only array that owns `values`; nothing is copied.
pub(crate) fn column<T: Element>(py: Python<'_>, values: Vec<T>) -> Bound<'_, PyAny> {
    let array = PyArray1::from_vec(py, values);
    freeze(array.readwrite());
    array.into_any()
}

/// A read-only array of rows of `width` values, which owns them.
pub(crate) fn rows<T: Element>(
    py: Python<'_>,
    values: Vec<T>,
    width: usize,
) -> Result<Bound<'_, PyAny>> {
    let height = values.len() / width.max(1);
    let array = PyArray1::from_vec(py, values).reshape([height, width])?;
    freeze(array.readwrite());
    Ok(array.into_any())
}

fn freeze<T: Element, D: numpy::ndarray::Dimension>(array: PyReadwriteArray<'_, T, D>) {
    drop(array.make_nonwriteable());
}

/// A matrix for column vectors, as numpy writes it: `matrix @ point`.
pub(crate) fn matrix(py: Python<'_>, matrix: DMat4) -> Result<Bound<'_, PyAny>> {
    rows(py, matrix.transpose().to_cols_array().to_vec(), 4)
}

/// The matrix of 4 × 4 numbers for column vectors.
pub(crate) fn read_matrix(given: &Bound<'_, PyAny>) -> Result<DMat4> {
    let rows: [[f64; 4]; 4] = given
        .extract()
        .map_err(|_| Failure::setting("a matrix has 4 rows of 4 numbers, for column vectors"))?;
    Ok(DMat4::from_cols_array_2d(&rows).transpose())
}

/// A two-dimensional array of `height` rows of values with `channels` numbers each, or of
/// numbers if there is one.
pub(crate) fn picture(
    py: Python<'_>,
    values: Vec<f32>,
    [height, width]: [usize; 2],
    channels: usize,
) -> Result<Bound<'_, PyAny>> {
    let flat = PyArray1::from_vec(py, values);
    Ok(if channels == 1 {
        let array: Bound<'_, PyArray2<f32>> = flat.reshape([height, width])?;
        array.into_any()
    } else {
        flat.reshape([height, width, channels])?.into_any()
    })
}

/// Whole numbers below 2³². One that is not becomes 2³² − 1, which is an index of nothing.
///
/// # Errors
///
/// `TypeError` for numbers that are not whole: a cast would cut them off.
pub(crate) fn indices(given: &Bound<'_, PyAny>, what: &str) -> PyResult<Vec<u32>> {
    let array = given.py().import("numpy")?.call_method1("asarray", (given,))?;
    let untyped = array.cast::<PyUntypedArray>()?;
    let (kind, size) = (untyped.dtype().kind(), untyped.dtype().itemsize());
    if untyped.len() > 0 && !matches!(kind, b'u' | b'i') {
        return Err(PyTypeError::new_err(format!("{what}: integers are needed")));
    }
    if kind == b'u' && size <= 4 {
        let numbers: PyArrayLike1<'_, u32, AllowTypeChange> = array.extract()?;
        return Ok(numbers.as_array().to_vec());
    }
    // What is beyond 2⁶³ becomes negative.
    let numbers: PyArrayLike1<'_, i64, AllowTypeChange> = array.extract()?;
    Ok(numbers.as_array().iter().map(|&n| u32::try_from(n).unwrap_or(u32::MAX)).collect())
}
