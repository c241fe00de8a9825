//! Errors of remote files.

use std::io;
use std::time::Duration;

/// Why a remote file could not be read or written. One line, without the address:
/// whoever opened it knows that, and adds it without secrets ([`shown`](crate::shown)).
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The crate was built without the feature `stores`.
    #[error(
        "this program was built without object stores: build it with the feature \"remote\", or fetch the file"
    )]
    NotBuilt,
    /// An address that is none, or not one that is taken.
    #[error("{0}")]
    Address(&'static str),
    /// A setting of the environment that is no such value.
    #[error("{name}: {reason}")]
    Setting {
        /// The environment's variable.
        name: &'static str,
        /// What it should be.
        reason: &'static str,
    },
    /// The store's client cannot be made: a region, an endpoint or a credential is missing.
    #[error("the store's settings in the environment do not serve")]
    Client(#[source] Refusal),
    /// There is no such object.
    #[error("there is no such object")]
    NotFound(#[source] Refusal),
    /// An object of no bytes, of which no range can be asked for.
    #[error("the object is empty")]
    Empty,
    /// The store wants other credentials.
    #[error("the store denies access: it takes credentials from the environment")]
    Denied(#[source] Refusal),
    /// The object is not the one that was opened.
    #[error("the object was replaced or removed while it was read; open it again")]
    Changed,
    /// The server sends whole files only.
    #[error("the server does not answer byte ranges; fetch the file and open the copy")]
    NoRanges,
    /// Nothing more came in time.
    #[error("no answer within {} s, tried {attempts} times", limit.as_secs_f64())]
    Timeout {
        /// The time that each attempt had.
        limit: Duration,
        /// Number of attempts.
        attempts: u32,
    },
    /// Answers ended early, each time.
    #[error("{got} of {asked} bytes came, tried {attempts} times")]
    Short {
        /// Bytes asked for.
        asked: u64,
        /// Bytes that came.
        got: u64,
        /// Number of attempts.
        attempts: u32,
    },
    /// A range that does not lie in the file.
    #[error("bytes {start} to {end} do not lie in a file of {length} bytes")]
    Range {
        /// The first byte asked for.
        start: u64,
        /// The one after the last.
        end: u64,
        /// Length of the file.
        length: u64,
    },
    /// The store, or the way to it, failed.
    #[error("the store does not answer as it should, tried {attempts} times")]
    Store {
        /// Number of attempts.
        attempts: u32,
        /// What it said.
        #[source]
        refusal: Refusal,
    },
    /// The store did not take a file, after as many attempts as were allowed.
    #[error("the store did not take it")]
    NotTaken(#[source] Refusal),
    /// Another thread read the same bytes, and this was its error.
    #[error(transparent)]
    Shared(std::sync::Arc<Error>),
    /// The operating system refused something on this machine.
    #[error("cannot {action}")]
    Io {
        /// The operation that failed.
        action: &'static str,
        /// The operating system's error.
        #[source]
        error: io::Error,
    },
    /// A file that is too large for the way that its store takes files.
    #[error(
        "a server without uploads in parts takes {limit} bytes at most, and the file has {length}"
    )]
    TooLarge {
        /// Length of the file.
        length: u64,
        /// The most that is sent in one request.
        limit: u64,
    },
}

impl Error {
    #[cfg(feature = "stores")]
    pub(crate) fn io(action: &'static str) -> impl FnOnce(io::Error) -> Self {
        move |error| Self::Io { action, error }
    }
}

/// What a store said: one line of at most some hundred characters.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{0}")]
pub struct Refusal(String);

#[cfg(feature = "stores")]
impl Refusal {
    /// The most characters of an answer that are kept.
    const MOST: usize = 300;

    /// The innermost reason of an error, which says most: what wraps it repeats it, and
    /// may be a page of XML on many lines.
    pub(crate) fn of(error: &(dyn std::error::Error + 'static)) -> Self {
        let mut innermost = error;
        while let Some(source) = innermost.source() {
            innermost = source;
        }
        Self::from_text(&innermost.to_string())
    }

    pub(crate) fn from_text(text: &str) -> Self {
        let visible = text.chars().map(|letter| if letter.is_control() { ' ' } else { letter });
        let line = visible.collect::<String>();
        let line = line.split_whitespace().collect::<Vec<_>>().join(" ");
        match line.char_indices().nth(Self::MOST) {
            Some((end, _)) => Self(format!("{} …", &line[..end])),
            None => Self(line),
        }
    }
}

/// The result of a fallible call of this crate.
pub(crate) type Result<T, E = Error> = std::result::Result<T, E>;
