//! Keyword arguments by their names.

use std::fmt::Write;

use pyo3::conversion::FromPyObjectOwned;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::{Failure, Result};

/// Keyword arguments, taken one after the other; `None` is as good as not given.
pub(crate) struct Options<'py>(Bound<'py, PyDict>);

impl<'py> Options<'py> {
    /// The keyword arguments of a call.
    pub(crate) fn new(py: Python<'py>, given: Option<&Bound<'py, PyDict>>) -> Result<Self> {
        Ok(Self(given.map_or_else(|| Ok(PyDict::new(py)), PyDictMethods::copy)?))
    }

    /// The argument of this name as an object.
    pub(crate) fn object(&self, name: &str) -> Result<Option<Bound<'py, PyAny>>> {
        let Some(value) = self.0.get_item(name)? else { return Ok(None) };
        self.0.del_item(name)?;
        Ok(Some(value).filter(|value| !value.is_none()))
    }

    /// The argument of this name.
    pub(crate) fn take<T: FromPyObjectOwned<'py>>(&self, name: &str) -> Result<Option<T>> {
        let Some(value) = self.object(name)? else { return Ok(None) };
        let taken: Result<T, PyErr> = value.extract::<T>().map_err(Into::into);
        taken.map(Some).map_err(|error| self.wrong(name, error).into())
    }

    /// The argument of this name, one of some words.
    pub(crate) fn word<T: Copy>(&self, name: &str, words: &[(&str, T)]) -> Result<Option<T>> {
        let Some(given) = self.take::<String>(name)? else { return Ok(None) };
        let found = words.iter().find(|(word, _)| *word == given);
        found.map(|&(_, value)| Some(value)).ok_or_else(|| {
            let words: Vec<_> = words.iter().map(|(word, _)| *word).collect();
            Failure::setting(format!("{name}: '{given}' is none of {}", words.join(", ")))
        })
    }

    /// Refuses what is left.
    pub(crate) fn finish(self, function: &str) -> Result<()> {
        let Some(name) = self.0.keys().iter().next() else { return Ok(()) };
        let reason = format!("{function}() got an unexpected keyword argument {}", name.repr()?);
        Err(PyTypeError::new_err(reason).into())
    }

    /// An exception of the same class that names the argument.
    fn wrong(&self, name: &str, error: PyErr) -> PyErr {
        let py = self.0.py();
        let mut message = format!("{name}: ");
        // Writing to a string never fails.
        let _ = write!(message, "{}", error.value(py));
        PyErr::from_type(error.get_type(py), message)
    }
}
