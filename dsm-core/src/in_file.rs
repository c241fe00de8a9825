//! Errors of files.

use std::error::Error;
use std::fmt;
use std::path::{Path, PathBuf};

/// An error, and the file that it is about: its message begins with the path.
///
/// The error itself is part of the message, so that its own cause is what
/// follows: [`source`](Error::source) is the source of the error.
///
/// ```
/// use std::error::Error;
/// use std::io;
///
/// #[derive(Debug, thiserror::Error)]
/// #[error("cannot open")]
/// struct Open(#[source] io::Error);
///
/// let error = dsm_core::detail::InFile::new("hair.dsm".as_ref(), Open(io::ErrorKind::NotFound.into()));
/// assert_eq!(error.to_string(), "hair.dsm: cannot open");
/// assert!(error.source().is_some_and(|cause| cause.is::<io::Error>()));
/// ```
#[derive(Debug)]
pub struct InFile<E> {
    /// The file.
    pub path: PathBuf,
    /// The error itself.
    pub error: Box<E>,
}

impl<E> InFile<E> {
    /// This error in this file.
    #[must_use]
    pub fn new(path: &Path, error: E) -> Self {
        Self { path: path.to_owned(), error: Box::new(error) }
    }
}

impl<E: fmt::Display> fmt::Display for InFile<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.path.display(), self.error)
    }
}

impl<E: Error> Error for InFile<E> {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        self.error.source()
    }
}
