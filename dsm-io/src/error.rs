//! What can be wrong with a file, and where in it.

use std::borrow::Cow;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::format::section::SectionKind;
use crate::format::tile_id::TileId;

/// A part of a `.dsm` file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Place {
    /// The 64 bytes that the file begins with.
    Prologue,
    /// The table of all sections.
    SectionTable,
    /// A section.
    Section {
        /// Its index in the table.
        index: u32,
        /// What it holds.
        kind: SectionKind,
    },
    /// A level's record, by its index.
    Level(u32),
    /// A tile's entry in its level's directory.
    Entry(TileId),
    /// A tile's payload.
    Tile {
        /// Which tile.
        id: TileId,
        /// Where its payload begins in the file, in bytes.
        offset: u64,
    },
    /// These bytes of the file.
    Bytes {
        /// The first.
        start: u64,
        /// The one after the last.
        end: u64,
    },
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Prologue => f.write_str("prologue"),
            Self::SectionTable => f.write_str("section table"),
            Self::Section { index, kind } => write!(f, "section {index} ({kind})"),
            Self::Level(index) => write!(f, "level {index}"),
            Self::Entry(id) => write!(f, "directory entry of {id}"),
            Self::Tile { id, offset } => write!(f, "{id} at byte {offset}"),
            Self::Bytes { start, end } => write!(f, "bytes {start} to {end}"),
        }
    }
}

/// Why a file could not be read or written: what, where in it, and why. The
/// message is one line and complete.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// What went wrong with this file.
    #[error("{}: {error}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What went wrong.
        error: Box<Error>,
    },
    /// The operating system refused.
    #[error("cannot {action}: {error}")]
    Io {
        /// What was tried.
        action: &'static str,
        /// Its answer.
        error: io::Error,
    },
    /// Not a file of this format.
    #[error("not a .dsm file of this format: {0}")]
    NotDsm(&'static str),
    /// Written by a program of another major version.
    #[error("written by {} version {major}.{minor} of the format; this program reads 1.x",
            if *.major > 1 { "a newer" } else { "an unknown" })]
    Version {
        /// The file's major version.
        major: u16,
        /// The file's minor version.
        minor: u16,
    },
    /// The file uses something that must be understood and is not.
    #[error("{place}: {what} is unknown to this program and required to read the file")]
    Unsupported {
        /// Where it is used.
        place: Place,
        /// What it is.
        what: String,
    },
    /// The file is shorter than it says.
    #[error("truncated: {actual} of {stated} bytes are there")]
    Truncated {
        /// The length that the file states.
        stated: u64,
        /// The length that it has.
        actual: u64,
    },
    /// The file is longer than it says.
    #[error("{} bytes follow the end of the map", actual - stated)]
    Trailing {
        /// The length that the file states.
        stated: u64,
        /// The length that it has.
        actual: u64,
    },
    /// Stored bytes are not the ones that were written.
    #[error("{place}: checksum {computed:08x}, but {stored:08x} was written")]
    Checksum {
        /// Where.
        place: Place,
        /// The checksum that is stored.
        stored: u32,
        /// The checksum of what is there.
        computed: u32,
    },
    /// Something that the format does not allow.
    #[error("{place}: {reason}")]
    Invalid {
        /// Where.
        place: Place,
        /// Which rule it breaks.
        reason: Cow<'static, str>,
    },
    /// An OpenEXR file that cannot be read.
    #[error(transparent)]
    DeepExr(#[from] deep_exr::Error),
    /// What a bake looks at could not answer.
    #[error(transparent)]
    HitSource(Box<dyn std::error::Error + Send + Sync>),
    /// The caller broke it off.
    #[error("interrupted")]
    Interrupted,
    /// A value that the library's core refused.
    #[error(transparent)]
    Core(#[from] dsm_core::Error),
    /// A map that is further from its source than it states.
    #[error(
        "pixel ({}, {}) is off by {:.6} at depth {}, channel {}; the map states a tolerance of {stated}",
        worst.x, worst.y, worst.difference, worst.z, worst.channel
    )]
    Bound {
        /// The map's tolerance.
        stated: f32,
        /// Where it is furthest off, and by how much.
        worst: crate::WorstPixel,
    },
    /// Pixels that are no visibility functions.
    #[error("{place}: {error}")]
    Function {
        /// Where.
        place: Place,
        /// Which pixel, and what is wrong with it.
        error: dsm_core::Error,
    },
    /// More than [`Limits`](crate::Limits) allow.
    #[error("{what}: {count} is more than the limit of {limit}")]
    Limit {
        /// What there is too much of.
        what: &'static str,
        /// How many there are.
        count: u64,
        /// How many there may be.
        limit: u64,
    },
    /// Metadata that does not say what it must.
    #[error("metadata: {0}")]
    Metadata(String),
    /// A map of another kind.
    #[error("a map of kind \"{found}\", not {wanted}")]
    Kind {
        /// What the metadata name.
        found: String,
        /// What was asked for.
        wanted: &'static str,
    },
    /// A mono map was asked for colours, or a coloured one for one channel.
    #[error("the map has {channels} channel(s), not {asked}")]
    Channels {
        /// The map's number of channels.
        channels: u8,
        /// The number that was asked for.
        asked: u8,
    },
    /// No such level.
    #[error("there is no level {0}")]
    NoSuchLevel(u32),
    /// No such tile.
    #[error("there is no {0}")]
    NoSuchTile(TileId),
    /// A tile that was written before.
    #[error("{0} was written before")]
    WrittenTwice(TileId),
    /// What went wrong with a tile that several threads waited for: each gets
    /// this one error.
    #[error(transparent)]
    Shared(Arc<Error>),
    /// A caller's value that the format cannot hold.
    #[error("{0}")]
    Caller(Cow<'static, str>),
}

impl Error {
    pub(crate) fn io(action: &'static str) -> impl FnOnce(io::Error) -> Self {
        move |error| Self::Io { action, error }
    }

    pub(crate) fn invalid(place: Place, reason: impl Into<Cow<'static, str>>) -> Self {
        Self::Invalid { place, reason: reason.into() }
    }

    pub(crate) fn caller(reason: impl Into<Cow<'static, str>>) -> Self {
        Self::Caller(reason.into())
    }

    /// Names the file in the error, unless it names one already.
    #[must_use]
    pub fn in_file(self, path: Option<&Path>) -> Self {
        match (self, path) {
            (error @ Self::File { .. }, _) | (error, None) => error,
            (error, Some(path)) => Self::File { path: path.to_owned(), error: Box::new(error) },
        }
    }
}

/// Refuses a `count` above its `limit`.
pub(crate) const fn check_limit(what: &'static str, count: u64, limit: u64) -> Result<()> {
    if count <= limit { Ok(()) } else { Err(Error::Limit { what, count, limit }) }
}

/// The result of a fallible call of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;
