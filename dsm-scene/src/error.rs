//! Errors of scenes and of their files, and the place of an error in a file.

use std::borrow::Cow;
use std::path::Path;
use std::{fmt, io};

use dsm_core::detail::InFile;

use crate::scene_memory::Mebibytes;

/// A part of a file or of an object.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Place {
    /// The whole file or object.
    Whole,
    /// The header.
    Header,
    /// A line of a text file, from 1.
    Line(u64),
    /// A byte's offset from the start.
    Byte(u64),
    /// A vertex, from 0.
    Vertex(u64),
    /// A triangle or polygon, from 0.
    Face(u64),
    /// A strand of hair, from 0.
    Strand(u64),
    /// A point of a strand, counted through the file from 0.
    Point(u64),
    /// A voxel, by its index.
    Voxel([i32; 3]),
    /// A part with a name or an index in the file.
    Named(String),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole => f.write_str("file"),
            Self::Header => f.write_str("header"),
            Self::Line(line) => write!(f, "line {line}"),
            Self::Byte(offset) => write!(f, "byte {offset}"),
            Self::Vertex(index) => write!(f, "vertex {index}"),
            Self::Face(index) => write!(f, "face {index}"),
            Self::Strand(index) => write!(f, "strand {index}"),
            Self::Point(index) => write!(f, "point {index}"),
            Self::Voxel([x, y, z]) => write!(f, "voxel ({x}, {y}, {z})"),
            Self::Named(name) => f.write_str(name),
        }
    }
}

/// The reason why a scene could not be made, with its place.
///
/// The message is one line. What the operating system said is not in it but the
/// [`source`](std::error::Error::source): print the chain.
///
/// ```
/// use std::error::Error as _;
///
/// let error = dsm_scene::detail::load_mesh("no/such.ply".as_ref()).unwrap_err();
/// let cause = error.source().and_then(|cause| cause.downcast_ref::<std::io::Error>());
/// assert_eq!(cause.map(|cause| cause.kind()), Some(std::io::ErrorKind::NotFound));
/// ```
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An error in this file.
    #[error(transparent)]
    File(InFile<Error>),
    /// A failure of the operating system.
    #[error("cannot {action}")]
    Io {
        /// The action that failed.
        action: &'static str,
        /// Its answer.
        #[source]
        error: io::Error,
    },
    /// A scene that takes more memory than it may.
    #[error(
        "the scene takes {} of memory, more than the {} it may take: {largest}",
        Mebibytes(*needed),
        Mebibytes(*limit)
    )]
    Memory {
        /// The bytes that were needed when it was refused; there may be more.
        needed: u64,
        /// The bytes that it may take.
        limit: u64,
        /// What is large, and how large.
        largest: String,
    },
    /// A part of a file or object that breaks a rule.
    #[error("{place}: {reason}")]
    Malformed {
        /// The place in the file.
        place: Place,
        /// The rule that it breaks.
        reason: Cow<'static, str>,
    },
    /// A file that no loader is known for.
    #[error("unsupported format, {}: {expected}", match .extension {
        Some(extension) => format!(".{extension}"),
        None => "a file without an extension".to_owned(),
    })]
    UnknownFormat {
        /// The file's extension.
        extension: Option<String>,
        /// The supported formats.
        expected: &'static str,
    },
    /// A name that no built-in scene has.
    #[error("no built-in scene is named `{name}`; the names are {}", .known.join(", "))]
    UnknownBuiltin {
        /// The name.
        name: String,
        /// The names that there are.
        known: &'static [&'static str],
    },
    /// A quantity above the limit that is supported.
    #[error("{what}: {count} is more than {limit}")]
    TooLarge {
        /// The quantity that is too large.
        what: &'static str,
        /// The number that was given.
        count: u64,
        /// The largest number that is supported.
        limit: u64,
    },
    /// An error of the deep shadow map library.
    #[error(transparent)]
    Core(#[from] dsm_core::Error),
}

/// The result of a fallible call of this crate.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// Something at `place` that is not as it has to be.
    pub(crate) fn malformed(place: Place, reason: impl Into<Cow<'static, str>>) -> Self {
        Self::Malformed { place, reason: reason.into() }
    }

    /// The error with the file's name, unless it has one already.
    #[must_use]
    pub fn in_file(self, path: &Path) -> Self {
        match self {
            Self::File(_) => self,
            error => Self::File(InFile::new(path, error)),
        }
    }
}
