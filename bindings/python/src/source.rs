//! Functions of Python as hit sources.

use std::sync::{Mutex, PoisonError};

use deepshadow::scene::Light;
use deepshadow::visibility::{
    Error as CoreError, HitSource, Rgb, TileHits, TileSamples, Transmittance, ViewRaster,
};
use deepshadow::{AnyHitSource, Error, Occluders};
use numpy::{AllowTypeChange, PyArray1, PyArrayLike1, PyArrayLikeDyn, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::arrays;
use crate::view::View;

/// What a Python function sees through whatever view a map is baked from.
pub(crate) struct PythonOccluders<'a> {
    source: &'a Py<PyAny>,
    light: &'a Light,
    is_coloured: bool,
    has_media: bool,
    /// The exception that ended the bake.
    raised: Mutex<Option<PyErr>>,
}

/// Why a source gave no hits.
#[derive(Debug, thiserror::Error)]
enum HitError {
    /// An exception, which the caller gets as it is.
    #[error("{0}")]
    Python(String),
    #[error(transparent)]
    Core(#[from] CoreError),
}

/// The hits of a function through one view.
struct PythonHits<'a> {
    function: Py<PyAny>,
    occluders: &'a PythonOccluders<'a>,
}

impl<'a> PythonOccluders<'a> {
    /// `source` is a function of sample points, or has a method `through` that makes one
    /// for a view.
    pub(crate) fn new(
        source: &'a Py<PyAny>,
        light: &'a Light,
        is_coloured: bool,
        has_media: bool,
    ) -> Self {
        Self { source, light, is_coloured, has_media, raised: Mutex::new(None) }
    }

    /// The exception that ended the bake, if one did.
    pub(crate) fn take_raised(&self) -> Option<PyErr> {
        self.raised.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// Keeps the first exception.
    fn raise(&self, error: PyErr) -> HitError {
        let message = error.to_string();
        self.raised.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
        HitError::Python(message)
    }

    fn through(&self, view: &ViewRaster) -> Result<PythonHits<'_>, Error> {
        let found = Python::attach(|py| -> PyResult<Option<Py<PyAny>>> {
            let source = self.source.bind(py);
            if source.hasattr("through")? {
                return Ok(Some(source.call_method1("through", (View::from(*view),))?.unbind()));
            }
            Ok((view.eye() == self.light.view.eye).then(|| self.source.clone_ref(py)))
        });
        match found {
            Ok(Some(function)) => Ok(PythonHits { function, occluders: self }),
            Ok(None) => {
                let reason = "this kind of map is seen from behind an area light: give an object \
                              with a method through(view), which returns the function for that view";
                Err(Error::Unsupported(reason.to_owned()))
            }
            Err(error) => Err(Error::Occluders(Box::new(self.raise(error)))),
        }
    }
}

impl Occluders for PythonOccluders<'_> {
    fn is_coloured(&self) -> bool {
        self.is_coloured
    }

    fn mono(&self, view: &ViewRaster) -> Result<AnyHitSource<'_, f32>, Error> {
        self.through(view).map(AnyHitSource::new)
    }

    fn rgb(&self, view: &ViewRaster) -> Result<AnyHitSource<'_, Rgb>, Error> {
        self.through(view).map(AnyHitSource::new)
    }
}

impl<T: Transmittance> HitSource<T> for PythonHits<'_> {
    type Error = HitError;

    fn hits(&self, samples: &TileSamples, hits: &mut TileHits<T>) -> Result<(), HitError> {
        let raise = |error| self.occluders.raise(error);
        Python::attach(|py| {
            let columns = (
                PyArray1::from_slice(py, samples.x()),
                PyArray1::from_slice(py, samples.y()),
                PyArray1::from_slice(py, samples.times()),
            );
            let answer = self.function.bind(py).call1(columns).map_err(raise)?;
            let answer = Answer::<T>::read(&answer, self.occluders.has_media).map_err(raise)?;
            // The arrays are held until they are read.
            answer.push(hits)
        })
    }

    fn has_media(&self) -> bool {
        self.occluders.has_media
    }
}

/// The columns of an answer.
struct Answer<'py, T> {
    samples: Vec<u32>,
    depths: PyArrayLike1<'py, f32, AllowTypeChange>,
    opacities: Vec<T>,
    backs: Option<PyArrayLike1<'py, f32, AllowTypeChange>>,
}

impl<'py, T: Transmittance> Answer<'py, T> {
    fn read(answer: &Bound<'py, PyAny>, has_media: bool) -> PyResult<Self> {
        let tuple = answer.cast::<PyTuple>().ok().filter(|tuple| [3, 4].contains(&tuple.len()));
        let Some(tuple) = tuple else {
            let reason = "a hit source returns (sample, depth, opacity), or with media=True \
                          (sample, depth, opacity, back)";
            return Err(PyTypeError::new_err(reason));
        };
        if tuple.len() == 4 && !has_media {
            return Err(PyTypeError::new_err("hits with backs need media=True"));
        }
        let samples = arrays::indices(&tuple.get_item(0)?, "sample")?;
        let depths: PyArrayLike1<'py, f32, AllowTypeChange> = tuple.get_item(1)?.extract()?;
        let opacities = opacities(&tuple.get_item(2)?, depths.len())?;
        let backs = if tuple.len() == 4 { Some(tuple.get_item(3)?.extract()?) } else { None };
        Ok(Self { samples, depths, opacities, backs })
    }

    fn push(&self, hits: &mut TileHits<T>) -> Result<(), HitError> {
        let samples = &self.samples;
        let depths = contiguous(&self.depths);
        let Some(backs) = &self.backs else {
            return Ok(hits.push_surface_columns(samples, &depths, &self.opacities)?);
        };
        let backs = contiguous(backs);
        if samples.len() != depths.len() || backs.len() != depths.len() {
            return Ok(hits.push_surface_columns(samples, &depths, &[])?);
        }
        for (index, &sample) in samples.iter().enumerate() {
            let (near, far, opacity) = (depths[index], backs[index], self.opacities[index]);
            if far > near {
                hits.push_slab(sample, near, far, opacity)?;
            } else {
                hits.push_surface_columns(&[sample], &[near], &[opacity])?;
            }
        }
        Ok(())
    }
}

/// One opacity for all hits, one a hit, or a row of as many as the map has channels.
fn opacities<T: Transmittance>(given: &Bound<'_, PyAny>, count: usize) -> PyResult<Vec<T>> {
    let array: PyArrayLikeDyn<'_, f32, AllowTypeChange> = given.extract()?;
    let shape = array.shape().to_vec();
    let wrong = || {
        let channels = T::CHANNELS;
        let reason = format!(
            "opacities of shape {shape:?}: one number, ({count},) or ({count}, {channels}) are needed"
        );
        PyValueError::new_err(reason)
    };
    let view = array.as_array();
    Ok(match *shape.as_slice() {
        [] => vec![T::splat(view.first().copied().unwrap_or(f32::NAN)); count],
        [length] if length == count => view.iter().map(|&opacity| T::splat(opacity)).collect(),
        [length, channels] if length == count && channels == T::CHANNELS => {
            (0..length).map(|hit| T::from_channels(|channel| view[[hit, channel]])).collect()
        }
        _ => return Err(wrong()),
    })
}

/// The numbers of a column, copied only if they do not lie side by side.
fn contiguous<'a, E: numpy::Element + Copy>(
    array: &'a PyArrayLike1<'_, E, AllowTypeChange>,
) -> std::borrow::Cow<'a, [E]> {
    match array.as_slice() {
        Ok(numbers) => numbers.into(),
        Err(_) => array.as_array().iter().copied().collect(),
    }
}
