//! Why an OpenEXR file could not be read or written.

use std::io;
use std::path::PathBuf;

/// Failure to read or write a deep OpenEXR file: what failed, where in the file,
/// and why.
///
/// What the operating system said is the [`source`](std::error::Error::source),
/// and not part of the message.
///
/// ```
/// use std::error::Error as _;
/// use std::io;
///
/// use deep_exr::{DeepExrReader, Limits};
///
/// let error = DeepExrReader::open("no/such.exr".as_ref(), None, &Limits::default()).unwrap_err();
/// assert_eq!(error.to_string(), "cannot open no/such.exr");
/// let cause = error.source().and_then(|cause| cause.downcast_ref::<io::Error>());
/// assert_eq!(cause.map(io::Error::kind), Some(io::ErrorKind::NotFound));
/// ```
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The file could not be opened.
    #[error("cannot open {}", path.display())]
    Open {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },

    /// Reading from the open file failed.
    #[error("cannot read {length} bytes at offset {offset}")]
    Read {
        /// First byte wanted.
        offset: u64,
        /// Number of bytes wanted.
        length: usize,
        /// What the operating system said.
        source: io::Error,
    },

    /// The first bytes are not those of an OpenEXR file.
    #[error("not an OpenEXR file: {found}")]
    NotExr {
        /// What the file starts with, or is.
        found: String,
    },

    /// The file ends before something that it promises.
    #[error(
        "file ends in the middle of {what}: {length} bytes at offset {offset}, file of {file_length}"
    )]
    Truncated {
        /// What should be there.
        what: &'static str,
        /// Where it should begin.
        offset: u64,
        /// How long it should be.
        length: u64,
        /// How long the file is.
        file_length: u64,
    },

    /// A version or feature of OpenEXR that this reader does not know.
    #[error("unsupported OpenEXR file: {reason}")]
    UnsupportedVersion {
        /// What is unknown.
        reason: String,
    },

    /// A header is malformed, or contradicts itself.
    #[error("header of part {part}, attribute '{attribute}' (offset {offset}): {reason}")]
    Header {
        /// Index of the part in the file.
        part: usize,
        /// Name of the attribute.
        attribute: String,
        /// Where the attribute (or, where it is missing, its header) begins.
        offset: u64,
        /// What is wrong with it.
        reason: String,
    },

    /// The pixels are compressed in a way that this reader cannot unpack.
    #[error("part {part} is compressed with {compression}, {reason}")]
    UnsupportedCompression {
        /// The part: its index, and its name where it has one.
        part: String,
        /// Name of the compression.
        compression: String,
        /// Why it cannot be read, and what to do.
        reason: &'static str,
    },

    /// The part that was asked for is not in the file.
    #[error("no part is named '{name}'; the file has {parts}")]
    NoSuchPart {
        /// The name that was asked for.
        name: String,
        /// The parts that exist: names, types, channels.
        parts: String,
    },

    /// No part (or not the one asked for) says how deep its samples are.
    #[error("no depth to read: {reason}; the file has {parts}")]
    NoDepth {
        /// What was looked for.
        reason: &'static str,
        /// The parts that exist: names, types, channels.
        parts: String,
    },

    /// A part whose channels for depth and opacity are missing or not clear.
    #[error("part {part}: {reason}; its channels are {channels}")]
    Channels {
        /// The part: its index, and its name where it has one.
        part: String,
        /// What is missing or not clear.
        reason: String,
        /// Its channels.
        channels: String,
    },

    /// A choice of channels that is none.
    #[error("channels: {0}")]
    Selection(String),

    /// A size is above what the caller allows.
    #[error("{place}: {what} is {value}, the limit is {limit}")]
    LimitExceeded {
        /// Where in the file.
        place: String,
        /// What is too large.
        what: &'static str,
        /// Its size.
        value: u64,
        /// The limit, from [`Limits`](crate::limits::Limits).
        limit: u64,
    },

    /// A chunk (a scan line or a tile) is missing or damaged.
    #[error("{place} (offset {offset}): {reason}")]
    Chunk {
        /// The scan line (in the data window's coordinates) or the tile.
        place: String,
        /// Where the chunk begins.
        offset: u64,
        /// What is wrong with it.
        reason: String,
    },

    /// Writing to the output failed.
    #[error("cannot write")]
    Write(#[source] io::Error),

    /// An image that no OpenEXR file can be.
    #[error("no OpenEXR image: {0}")]
    Options(&'static str),

    /// An attribute that a written header cannot have.
    #[error("attribute '{name}' {reason}")]
    Attribute {
        /// Its name.
        name: String,
        /// Why.
        reason: &'static str,
    },

    /// Samples that are not those of the image that is written.
    #[error("{place}: {reason}")]
    Rows {
        /// The pixel rows or the chunk that they were given for.
        place: String,
        /// What does not fit.
        reason: &'static str,
    },

    /// The image was finished before all of its chunks were written.
    #[error("{missing} chunks were not written, the first of them {first}")]
    Incomplete {
        /// How many.
        missing: u64,
        /// The first of them.
        first: String,
    },

    /// The caller asked for rows that the image does not have.
    #[error("rows {start}..{end} are not inside 0..{height}")]
    RowsOutOfRange {
        /// First row asked for.
        start: u32,
        /// One past the last row asked for.
        end: u32,
        /// Rows of the data window.
        height: u32,
    },
}

/// The result of a fallible call of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;
