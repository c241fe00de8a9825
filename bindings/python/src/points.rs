//! Points and directions from arrays.

use numpy::ndarray::{ArrayViewD, Axis};
use numpy::{AllowTypeChange, PyArrayLikeDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::error::{Failure, Result};

/// Triples of numbers, and the shape that they were given in.
pub(crate) struct Points {
    /// All axes but the last.
    shape: Vec<usize>,
    points: Vec<[f64; 3]>,
}

impl Points {
    /// Anything that numpy makes an array of whose last axis has 3 numbers. Copies it, so
    /// that nobody changes it meanwhile.
    pub(crate) fn new(given: &Bound<'_, PyAny>, what: &str) -> Result<Self> {
        let array: PyArrayLikeDyn<'_, f64, AllowTypeChange> = given.extract()?;
        let Some((&3, shape)) = array.shape().split_last() else {
            let shape = array.shape();
            return Err(Failure::setting(format!(
                "{what}: an array of shape (…, 3), not {shape:?}"
            )));
        };
        // Not the array's own slice: that is there in Fortran's order, too.
        let view = array.as_array();
        let points = match view.as_slice() {
            Some(numbers) => numbers.as_chunks::<3>().0.to_vec(),
            None => strided(view),
        };
        Ok(Self { shape: shape.to_vec(), points })
    }

    /// The triples, the last axis but one fastest.
    pub(crate) fn all(&self) -> &[[f64; 3]] {
        &self.points
    }

    /// All axes but the last.
    pub(crate) fn shape(&self) -> &[usize] {
        &self.shape
    }
}

fn strided(array: ArrayViewD<'_, f64>) -> Vec<[f64; 3]> {
    let last = Axis(array.ndim() - 1);
    array.lanes(last).into_iter().map(|point| [0, 1, 2].map(|axis| point[axis])).collect()
}
