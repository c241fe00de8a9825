//! The switches of `diff`.

use std::path::PathBuf;

use clap::Args;

use super::values::Effort;

const EXAMPLES: &str = "\
Examples:
  dsm-tools diff old.dsm new.dsm --json";

/// Tells how far the visibility functions of two maps are apart
///
/// Prints the largest difference, at any depth and on both sides of steps, and
/// the mean one, over all pixels of all levels that both have. Maps that
/// differ are no failure.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct DiffFlags {
    /// A deep shadow map (.dsm), a deep .exr or a flat depth .exr
    a: PathBuf,
    /// Another one of the same size
    b: PathBuf,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    effort: Effort,
    /// Show no progress
    #[arg(long)]
    quiet: bool,
}

/// A checked `diff`.
#[derive(Debug)]
pub(crate) struct Diff {
    pub(crate) files: [PathBuf; 2],
    pub(crate) json: bool,
    pub(crate) effort: Effort,
    pub(crate) quiet: bool,
}

impl From<DiffFlags> for Diff {
    fn from(flags: DiffFlags) -> Self {
        let DiffFlags { a, b, json, effort, quiet } = flags;
        Self { files: [a, b], json, effort, quiet }
    }
}
