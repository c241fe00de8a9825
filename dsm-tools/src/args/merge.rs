//! The switches of `merge`.

use std::path::PathBuf;

use clap::Args;
use deepshadow::visibility::Tolerance;

use super::values::{self, Effort};

const EXAMPLES: &str = "\
Examples:
  dsm-tools merge hair.dsm smoke.dsm -o both.dsm --tolerance 0.001
  dsm-tools merge left.dsm right.dsm -o whole.dsm
  dsm-tools merge parts/*.dsm -o whole.dsm --expect plan.json";

/// Makes one map of several
///
/// Maps of the same pixels are multiplied: the transmittance of all of them. merge is exact where coverage is uncorrelated (two opaque halves of
/// one pixel multiply to ¼, truth ½ or 0). Crops of one map, which together
/// cover it, are put together as they are.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct MergeFlags {
    /// Maps of one kind (.dsm)
    #[arg(required = true, num_args = 1.., value_name = "MAP")]
    maps: Vec<PathBuf>,
    /// The map to write; it may be one of the others
    #[arg(short, long, value_name = "OUT", value_parser = values::dsm_file())]
    output: PathBuf,
    /// Error bound of the transmittance at any depth, in [0, 1), on top of what
    /// the maps state; 0 keeps every step [default: 0]. Not for crops
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    #[arg(value_parser = values::tolerance)]
    tolerance: Option<Tolerance>,
    /// The plan that the maps are parts of: what is missing, doubled or foreign is named
    #[arg(long, value_name = "PLAN.json", conflicts_with = "tolerance")]
    expect: Option<PathBuf>,
    #[command(flatten)]
    effort: Effort,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
    /// Show no progress, and print nothing but what --json asks for
    #[arg(long)]
    quiet: bool,
}

/// A checked `merge`.
#[derive(Debug)]
pub(crate) struct Merge {
    pub(crate) maps: Vec<PathBuf>,
    pub(crate) output: PathBuf,
    pub(crate) tolerance: Option<Tolerance>,
    pub(crate) expect: Option<PathBuf>,
    pub(crate) effort: Effort,
    pub(crate) json: bool,
    pub(crate) quiet: bool,
}

impl From<MergeFlags> for Merge {
    fn from(flags: MergeFlags) -> Self {
        let MergeFlags { maps, output, tolerance, expect, effort, json, quiet } = flags;
        Self { maps, output, tolerance, expect, effort, json, quiet }
    }
}
