//! Errors of files, with the place in the file.

use std::borrow::Cow;
use std::path::Path;
use std::sync::Arc;
use std::{fmt, io};

use dsm_core::detail::InFile;

use crate::limits::Limits;
use crate::section_kind::SectionKind;
use crate::tile_id::TileId;
use crate::worst_pixel::WorstPixel;

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
        /// The section's index in the table.
        index: u32,
        /// The section's kind.
        kind: SectionKind,
    },
    /// A level's record, by its index.
    Level(u32),
    /// A tile's entry in its level's directory.
    Entry(TileId),
    /// A tile's payload.
    Tile {
        /// The tile.
        id: TileId,
        /// The offset of its payload in the file, in bytes.
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

/// Why a file could not be read or written: what, and where in it.
///
/// The message is one line. What the operating system or another library said is
/// not in it but the [`source`](std::error::Error::source): print the chain.
///
/// ```
/// use std::error::Error as _;
/// use std::io;
///
/// use dsm_io::{Limits, MapReader};
///
/// let error = MapReader::open("no/such.dsm", &Limits::default()).unwrap_err();
/// assert_eq!(error.to_string(), "no/such.dsm: cannot open");
/// let cause = error.source().and_then(|cause| cause.downcast_ref::<io::Error>());
/// assert_eq!(cause.map(io::Error::kind), Some(io::ErrorKind::NotFound));
/// ```
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An error, with the file it concerns.
    #[error(transparent)]
    File(InFile<Error>),
    /// The operating system refused.
    #[error("cannot {action}")]
    Io {
        /// The operation that failed.
        action: &'static str,
        /// The operating system's error.
        #[source]
        error: io::Error,
    },
    /// A map takes more bytes than it may, whatever the tolerance.
    #[error("a map of {asked} bytes cannot be made: at the largest tolerance it takes {least}")]
    Size {
        /// Bytes that it may take.
        asked: u64,
        /// Bytes that it takes at the largest tolerance that is tried.
        least: u64,
    },
    /// A file in an object store that could not be read or written.
    #[error(transparent)]
    Remote(#[from] dsm_remote::Error),
    /// A finished file that did not reach its store. It is not lost.
    #[error("cannot send it to its store; the finished file is kept as {}", kept.display())]
    NotSent {
        /// The finished file on this machine.
        kept: std::path::PathBuf,
        /// What the store, or the way to it, refused.
        #[source]
        error: dsm_remote::Error,
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
        /// The place that uses it.
        place: Place,
        /// The unsupported feature.
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
        /// The place in the file.
        place: Place,
        /// The checksum that is stored.
        stored: u32,
        /// The checksum of what is there.
        computed: u32,
    },
    /// Something that the format does not allow.
    #[error("{place}: {reason}")]
    Invalid {
        /// The place in the file.
        place: Place,
        /// The broken rule.
        reason: Cow<'static, str>,
    },
    /// An OpenEXR file that cannot be read or written.
    #[error(transparent)]
    DeepExr(#[from] deep_exr::Error),
    /// An error of the hit source of a bake.
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
        /// The pixel with the largest error, and that error.
        worst: WorstPixel,
    },
    /// Pixels that are no visibility functions.
    #[error("{place}")]
    Function {
        /// The place in the file.
        place: Place,
        /// The pixel's number and the error of its function.
        #[source]
        error: dsm_core::Error,
    },
    /// More than [`Limits`] allow.
    #[error("{what}: {count} is more than the limit of {limit}")]
    Limit {
        /// The limited quantity.
        what: &'static str,
        /// The number found.
        count: u64,
        /// The number allowed.
        limit: u64,
    },
    /// A tile that readers would not accept by default.
    #[error(
        "a tile takes {bytes} bytes or more, and readers accept {limit}: smaller tiles, as --tile sets them, take less"
    )]
    TileTooLarge {
        /// What it takes, or what a part of it does.
        bytes: u64,
        /// The number allowed.
        limit: u64,
    },
    /// Metadata that does not say what it must.
    #[error("metadata: {0}")]
    Metadata(String),
    /// Metadata that are no JSON object with the keys of their kind.
    #[error("metadata")]
    Json(#[source] serde_json::Error),
    /// A map of another kind.
    #[error("a map of kind \"{found}\", not {wanted}")]
    Kind {
        /// The kind in the file.
        found: String,
        /// The kind that was expected.
        wanted: &'static str,
    },
    /// A query of a mono map for colours, or of a coloured map for one channel.
    #[error("the map has {channels} channel(s), not {asked}")]
    Channels {
        /// The map's number of channels.
        channels: u8,
        /// The number of the query.
        asked: u8,
    },
    /// No such level.
    #[error("there is no level {0}")]
    NoSuchLevel(u32),
    /// No such pixel.
    #[error("pixel ({}, {}) is outside the map", .0[0], .0[1])]
    NoSuchPixel([u32; 2]),
    /// No such section.
    #[error("there is no section {0}")]
    NoSuchSection(u32),
    /// No such tile.
    #[error("there is no {0}")]
    NoSuchTile(TileId),
    /// A tile that was written before.
    #[error("{0} was written before")]
    WrittenTwice(TileId),
    /// The error of a tile that several threads waited for: each gets
    /// this one error.
    #[error(transparent)]
    Shared(Arc<Error>),
    /// A tile that breaks a rule of the format, or is not the one that it is
    /// written as.
    #[error("{id}: {rule}")]
    Tile {
        /// The tile.
        id: TileId,
        /// The broken rule.
        rule: Cow<'static, str>,
    },
    /// A setting that is out of range, or has no use here.
    #[error("{0}")]
    Setting(Cow<'static, str>),
    /// Maps, or a map and a query, that do not go together.
    #[error("{0}")]
    Mismatch(Cow<'static, str>),
    /// A path that nothing can be read from or written to.
    #[error("{0}")]
    Path(&'static str),
}

impl Error {
    pub(crate) fn io(action: &'static str) -> impl FnOnce(io::Error) -> Self {
        move |error| Self::Io { action, error }
    }

    pub(crate) fn invalid(place: Place, reason: impl Into<Cow<'static, str>>) -> Self {
        Self::Invalid { place, reason: reason.into() }
    }

    pub(crate) fn setting(reason: impl Into<Cow<'static, str>>) -> Self {
        Self::Setting(reason.into())
    }

    pub(crate) fn mismatch(reason: impl Into<Cow<'static, str>>) -> Self {
        Self::Mismatch(reason.into())
    }

    /// The error with the file's name, unless it has one already or there is
    /// no file. Addresses are named without what may be secret in them.
    ///
    /// ```
    /// use dsm_io::Error;
    ///
    /// let error = Error::NoSuchLevel(3).in_file(std::path::Path::new("hair.dsm"));
    /// assert_eq!(error.to_string(), "hair.dsm: there is no level 3");
    /// ```
    #[must_use]
    pub fn in_file<'a>(self, path: impl Into<Option<&'a Path>>) -> Self {
        match (self, path.into()) {
            (error @ Self::File(_), _) | (error, None) => error,
            (error, Some(path)) => Self::File(InFile::new(&dsm_remote::shown(path), error)),
        }
    }
}

/// Refuses a tile to be written that readers refuse by default.
pub(crate) fn check_tile_bytes(bytes: u64) -> Result<()> {
    let limit = Limits::default().max_chunk_bytes;
    if bytes <= limit { Ok(()) } else { Err(Error::TileTooLarge { bytes, limit }) }
}

/// Refuses a `count` above its `limit`.
pub(crate) const fn check_limit(what: &'static str, count: u64, limit: u64) -> Result<()> {
    if count <= limit { Ok(()) } else { Err(Error::Limit { what, count, limit }) }
}

/// The result of a fallible call of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;
