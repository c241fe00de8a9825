//! A file in an object store.

use std::borrow::Cow;
use std::ops::Range;
use std::path::Path;

use dsm_remote::{RemoteFile, RemoteOptions, RemoteStatistics};

use super::Source;
use crate::error::{Error, Result};

/// A file in an object store, read by ranges.
///
/// [`Container::open`](crate::format::container::Container::open) makes one of an
/// address, with settings from the environment.
#[derive(Debug)]
pub struct RemoteSource(RemoteFile);

impl RemoteSource {
    /// Opens the file at an address, with settings from the environment.
    ///
    /// # Errors
    ///
    /// As [`Self::open_with`], and for settings that are none.
    pub fn open(address: &Path) -> Result<Self> {
        Self::open_with(address, &RemoteOptions::from_env()?)
    }

    /// Opens the file at an address.
    ///
    /// # Errors
    ///
    /// [`Error::Remote`] with what the address, the store or the way to it refuses.
    pub fn open_with(address: &Path, options: &RemoteOptions) -> Result<Self> {
        Ok(Self(RemoteFile::open(text(address)?, options)?))
    }

    /// Counts of the requests so far.
    #[must_use]
    pub fn statistics(&self) -> RemoteStatistics {
        self.0.statistics()
    }
}

/// An address as text, which every one is.
pub(crate) fn text(address: &Path) -> Result<&str> {
    address.to_str().ok_or(Error::Path("an address must be text"))
}

impl Source for RemoteSource {
    fn length(&self) -> u64 {
        self.0.length()
    }

    fn read(&self, range: Range<u64>) -> Result<Cow<'_, [u8]>> {
        Ok(Cow::Owned(self.0.read(range)?))
    }

    fn opened(&self) {
        self.0.opened();
    }

    fn remark(&self) -> Option<&str> {
        self.0.remark()
    }
}
