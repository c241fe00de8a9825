//! The switches of `merge`.

use std::path::PathBuf;

use clap::Args;
use deepshadow::visibility::Tolerance;

use super::values::{self, Effort};

/// Makes one map of several
///
/// Maps of the same pixels are multiplied: the light that gets past all of
/// them. merge is exact where coverage is uncorrelated (two opaque halves of
/// one pixel multiply to ¼, truth ½ or 0). Crops of one map, which together
/// cover it, are put together as they are.
#[derive(Debug, Args)]
pub(crate) struct MergeFlags {
    /// Deep shadow maps (.dsm)
    #[arg(required = true, num_args = 2.., value_name = "MAP")]
    maps: Vec<PathBuf>,
    /// The map to write; it may be one of the others
    #[arg(short, long, value_name = "OUT", value_parser = values::dsm_file())]
    output: PathBuf,
    /// How far the light may be off at any depth, in [0, 1), on top of what
    /// the maps state; 0 keeps every step [default: 0]. Not for crops
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    #[arg(value_parser = values::tolerance)]
    tolerance: Option<Tolerance>,
    #[command(flatten)]
    effort: Effort,
    /// Show no progress, and print nothing
    #[arg(long)]
    quiet: bool,
}

/// What `merge` was asked.
#[derive(Debug)]
pub(crate) struct Merge {
    pub(crate) maps: Vec<PathBuf>,
    pub(crate) output: PathBuf,
    pub(crate) tolerance: Option<Tolerance>,
    pub(crate) effort: Effort,
    pub(crate) quiet: bool,
}

impl From<MergeFlags> for Merge {
    fn from(flags: MergeFlags) -> Self {
        let MergeFlags { maps, output, tolerance, effort, quiet } = flags;
        Self { maps, output, tolerance, effort, quiet }
    }
}
