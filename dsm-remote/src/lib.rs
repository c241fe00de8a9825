//! Files in object stores: read by ranges of bytes, written whole.
//!
//! [`RemoteFile`] opens `s3://`, `gs://`, `az://`, `abfss://`, `https://` and `http://`
//! addresses. It holds every answer to the version that it opened, so that what is read
//! is one file or an error. [`upload`] puts a finished file into a store, where it is
//! seen only when it is whole.
//!
//! The clients come with the feature `stores`; without it [`is_url`] still knows an
//! address, and everything else answers [`Error::NotBuilt`].

mod address;
mod error;
mod options;
mod statistics;

#[cfg(not(feature = "stores"))]
mod absent;
#[cfg(feature = "stores")]
mod stores;

#[cfg(not(feature = "stores"))]
pub use absent::{RemoteFile, check_address, upload};
#[cfg(feature = "stores")]
pub use stores::{connect::check_address, file::RemoteFile, upload::upload};

pub use address::{is_url, shown};
pub use error::Error;
pub use options::RemoteOptions;
pub use statistics::RemoteStatistics;
