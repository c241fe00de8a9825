//! Errors as exceptions, with the file and the place in it.

use std::error::Error;
use std::path::PathBuf;

use deepshadow::files::deep_exr;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

/// What a call fails with.
#[derive(Debug)]
pub(crate) enum Failure {
    /// An error of the libraries.
    Front(deepshadow::Error),
    /// An exception, of a caller's function or of Python itself.
    Python(PyErr),
}

/// Results of this crate.
pub(crate) type Result<T, E = Failure> = std::result::Result<T, E>;

impl Failure {
    /// That an argument is not what it can be.
    pub(crate) fn setting(reason: impl Into<String>) -> Self {
        Self::Python(exception("SettingError", reason.into(), None, None))
    }

    /// That the caller's progress function broke the work off.
    pub(crate) fn cancelled() -> Self {
        Self::Front(deepshadow::Error::Interrupted)
    }
}

impl From<deepshadow::Error> for Failure {
    fn from(error: deepshadow::Error) -> Self {
        Self::Front(error)
    }
}

impl From<deepshadow::files::Error> for Failure {
    fn from(error: deepshadow::files::Error) -> Self {
        Self::Front(error.into())
    }
}

impl From<deepshadow::visibility::Error> for Failure {
    fn from(error: deepshadow::visibility::Error) -> Self {
        Self::Front(error.into())
    }
}

impl From<deepshadow::scene::Error> for Failure {
    fn from(error: deepshadow::scene::Error) -> Self {
        Self::Front(error.into())
    }
}

impl From<PyErr> for Failure {
    fn from(error: PyErr) -> Self {
        Self::Python(error)
    }
}

impl From<deep_exr::Error> for Failure {
    fn from(error: deep_exr::Error) -> Self {
        Self::Front(deepshadow::files::Error::DeepExr(error).into())
    }
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        let error = match failure {
            Failure::Python(error) => return error,
            Failure::Front(error) => error,
        };
        let (class, file, place) = match &error {
            deepshadow::Error::File(error) => of_file(error),
            deepshadow::Error::Scene(error) => of_scene(error),
            deepshadow::Error::Query { path, .. } => ("QueryError", Some(path.clone()), None),
            deepshadow::Error::Occluders(_) => ("HitSourceError", None, None),
            deepshadow::Error::Interrupted => ("Cancelled", None, None),
            _ => ("SettingError", None, None),
        };
        exception(class, whole_message(&error), file, place)
    }
}

/// The message of an error and of its causes, in one line.
pub(crate) fn whole_message(error: &dyn Error) -> String {
    let mut message = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        message = format!("{message}: {error}");
        cause = error.source();
    }
    message
}

type Described = (&'static str, Option<PathBuf>, Option<String>);

fn of_file(error: &deepshadow::files::Error) -> Described {
    use deepshadow::files::Error as E;

    match error {
        E::File(inner) => {
            let (class, _, place) = of_file(&inner.error);
            (class, Some(inner.path.clone()), place)
        }
        E::Interrupted => ("Cancelled", None, None),
        E::HitSource(_) => ("HitSourceError", None, None),
        E::Setting(_) | E::Mismatch(_) | E::Core(_) => ("SettingError", None, None),
        E::Shared(error) => of_file(error),
        E::Unsupported { place, .. }
        | E::Checksum { place, .. }
        | E::Invalid { place, .. }
        | E::Function { place, .. } => ("FileError", None, Some(place.to_string())),
        E::Tile { id, .. } | E::NoSuchTile(id) => ("FileError", None, Some(id.to_string())),
        E::Bound { worst, .. } => {
            let place = format!("level {}, pixel ({}, {})", worst.level, worst.x, worst.y);
            ("FileError", None, Some(place))
        }
        E::DeepExr(error) => of_image(error),
        _ => ("FileError", None, None),
    }
}

fn of_image(error: &deep_exr::Error) -> Described {
    use deep_exr::Error as E;

    match error {
        E::Open { path, .. } => ("FileError", Some(path.clone()), None),
        E::Header { part, attribute, .. } => {
            ("FileError", None, Some(format!("part {part}, attribute '{attribute}'")))
        }
        E::Chunk { place, .. } | E::LimitExceeded { place, .. } => {
            ("FileError", None, Some(place.clone()))
        }
        E::Truncated { offset, .. } | E::Read { offset, .. } => {
            ("FileError", None, Some(format!("byte {offset}")))
        }
        E::Selection(_) | E::Options(_) | E::Attribute { .. } | E::Rows { .. } => {
            ("SettingError", None, None)
        }
        _ => ("FileError", None, None),
    }
}

fn of_scene(error: &deepshadow::scene::Error) -> Described {
    use deepshadow::scene::Error as E;

    match error {
        E::File(inner) => {
            let (class, _, place) = of_scene(&inner.error);
            (class, Some(inner.path.clone()), place)
        }
        E::Malformed { place, .. } => ("SceneError", None, Some(place.to_string())),
        E::UnknownBuiltin { .. } => ("SceneError", None, None),
        E::Core(_) => ("SettingError", None, None),
        _ => ("SceneError", None, None),
    }
}

/// An exception of a class of `deepshadow._errors`.
fn exception(class: &str, message: String, file: Option<PathBuf>, place: Option<String>) -> PyErr {
    let file = file.filter(|path| !path.as_os_str().is_empty());
    Python::attach(|py| {
        let made =
            py.import("deepshadow._errors").and_then(|errors| errors.getattr(class)).and_then(
                |class| class.call1((&message, file.map(|f| f.display().to_string()), place)),
            );
        match made {
            Ok(exception) => PyErr::from_value(exception),
            // Only without the package around this module.
            Err(_) => PyRuntimeError::new_err(message),
        }
    })
}
