//! Errors of the front door.

use std::path::{Path, PathBuf};

use dsm_io::detail::{KindReader, MapKind};

/// An error of the front door; [`source`](std::error::Error::source) leads to its
/// cause.
///
/// ```
/// use std::error::Error as _;
///
/// let error = deepshadow::ShadowMap::open("no/such.dsm").unwrap_err();
/// assert!(matches!(error, deepshadow::Error::File(_)));
/// assert!(error.source().is_some());
/// ```
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A map or another file is not what it should be, or cannot be read or
    /// written.
    #[error(transparent)]
    File(#[from] dsm_io::Error),
    /// Settings, cameras or functions are not sound.
    #[error(transparent)]
    Core(#[from] dsm_core::Error),
    /// A scene is not sound.
    #[error(transparent)]
    Scene(#[from] dsm_scene::Error),
    /// A map cannot answer a query.
    #[error("{}: {reason}", path.display())]
    Query {
        /// The map's file.
        path: PathBuf,
        /// The reason, and a remedy.
        reason: String,
    },
    /// Settings that the kind of map does not have.
    #[error("{0}")]
    Unsupported(String),
    /// An error of the occluders of a bake.
    #[error(transparent)]
    Occluders(Box<dyn std::error::Error + Send + Sync>),
    /// The caller's progress function broke it off.
    #[error("interrupted")]
    Interrupted,
}

/// Results of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// That a map cannot answer a query, and why.
    pub(crate) fn query<K: MapKind>(map: &KindReader<K>, reason: impl Into<String>) -> Self {
        let path = map.container().path().unwrap_or(Path::new("")).to_owned();
        Self::Query { path, reason: reason.into() }
    }
}

impl From<std::convert::Infallible> for Error {
    fn from(never: std::convert::Infallible) -> Self {
        match never {}
    }
}
