//! What stands for the stores in a build without them.

use std::fs::File;
use std::ops::Range;

use crate::error::{Error, Result};
use crate::options::RemoteOptions;
use crate::statistics::RemoteStatistics;

/// A file in an object store, of which there is none in a build without the feature
/// `stores`.
#[derive(Debug)]
pub enum RemoteFile {}

impl RemoteFile {
    /// Says that there are no object stores.
    ///
    /// # Errors
    ///
    /// [`Error::NotBuilt`].
    pub const fn open(_address: &str, _options: &RemoteOptions) -> Result<Self> {
        Err(Error::NotBuilt)
    }

    /// Length in bytes.
    #[must_use]
    pub const fn length(&self) -> u64 {
        match *self {}
    }

    /// The bytes of a range.
    ///
    /// # Errors
    ///
    /// None: there is no such file.
    pub const fn read(&self, _range: Range<u64>) -> Result<Vec<u8>> {
        match *self {}
    }

    /// Ends the opening.
    pub const fn opened(&self) {
        match *self {}
    }

    /// What cannot be told of a file replaced meanwhile.
    #[must_use]
    pub const fn remark(&self) -> Option<&'static str> {
        match *self {}
    }

    /// Counts of requests.
    #[must_use]
    pub const fn statistics(&self) -> RemoteStatistics {
        match *self {}
    }
}

/// Says that there are no object stores.
///
/// # Errors
///
/// [`Error::NotBuilt`].
pub const fn check_address(_address: &str, _options: &RemoteOptions) -> Result<()> {
    Err(Error::NotBuilt)
}

/// Says that there are no object stores.
///
/// # Errors
///
/// [`Error::NotBuilt`].
pub const fn upload(_file: &mut File, _address: &str, _options: &RemoteOptions) -> Result<()> {
    Err(Error::NotBuilt)
}
