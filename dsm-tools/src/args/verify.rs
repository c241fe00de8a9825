//! The switches of `verify`.

use std::path::PathBuf;

use clap::Args;

/// Checks every checksum and every invariant of maps
#[derive(Debug, Args)]
pub(crate) struct VerifyFlags {
    /// Deep shadow maps (.dsm)
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

/// What `verify` was asked.
#[derive(Debug)]
pub(crate) struct Verify {
    pub(crate) files: Vec<PathBuf>,
    pub(crate) json: bool,
}

impl From<VerifyFlags> for Verify {
    fn from(flags: VerifyFlags) -> Self {
        let VerifyFlags { files, json } = flags;
        Self { files, json }
    }
}
