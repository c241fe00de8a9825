//! The switches of `verify`.

use std::path::PathBuf;

use clap::Args;
use deepshadow::files::deep_exr::Selection;

use super::selection::SelectionFlags;
use super::values::{Effort, Strictness};

const EXAMPLES: &str = "\
Examples:
  dsm-tools verify map.dsm other.dsm
  dsm-tools verify map.dsm --against deep.exr --json";

/// Checks every checksum and every invariant of maps
///
/// With --against also that each map keeps its stated tolerance to the file
/// that it was made of.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct VerifyFlags {
    /// Deep shadow maps (.dsm)
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Check the stated tolerance against this deep .exr, flat depth .exr or
    /// .dsm
    #[arg(long, value_name = "SOURCE")]
    against: Option<PathBuf>,
    #[command(flatten)]
    selection: SelectionFlags,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    effort: Effort,
    /// Show no progress
    #[arg(long)]
    quiet: bool,
    #[command(flatten)]
    strictness: Strictness,
}

/// A checked `verify`.
#[derive(Debug)]
pub(crate) struct Verify {
    pub(crate) files: Vec<PathBuf>,
    pub(crate) against: Option<PathBuf>,
    pub(crate) selection: Selection,
    pub(crate) json: bool,
    pub(crate) effort: Effort,
    pub(crate) quiet: bool,
    pub(crate) strict: bool,
}

impl TryFrom<VerifyFlags> for Verify {
    type Error = &'static str;

    fn try_from(flags: VerifyFlags) -> Result<Self, Self::Error> {
        let VerifyFlags { files, against, selection, json, effort, quiet, strictness } = flags;
        let Strictness { strict } = strictness;
        if selection.is_given() && against.is_none() {
            return Err("--part, --layer and --channels choose of the SOURCE that --against names");
        }
        Ok(Self { files, against, selection: selection.into(), json, effort, quiet, strict })
    }
}
