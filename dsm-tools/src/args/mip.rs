//! The switches of `mip`.

use std::path::PathBuf;

use clap::Args;
use clap::builder::RangedU64ValueParser;
use deepshadow::files::PyramidOptions;

use super::values::{self, Effort};

const EXAMPLES: &str = "\
Examples:
  dsm-tools mip map.dsm -o map.dsm
  dsm-tools mip map.dsm -o small.dsm --levels 4";

/// Gives a map the levels of a mip pyramid
///
/// Each level is half as wide and high as the one before, rounded up, down to
/// 1 × 1: lookups with wide filters read few pixels of a coarse level instead
/// of many of the map. Level 0 stays as it is; smaller levels that IN has are
/// replaced.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct MipFlags {
    /// A deep shadow map (.dsm)
    #[arg(value_name = "IN")]
    input: PathBuf,
    /// The map to write; may be IN, which is replaced then
    #[arg(short, long, value_name = "OUT", value_parser = values::dsm_file())]
    output: PathBuf,
    /// Maximum number of levels of OUT, with level 0 [default: down to 1 × 1]
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<u32>::new().range(1..=64))]
    levels: Option<u32>,
    /// Factor of the tolerance from level to level, in (0, 1];
    /// no level is held to less than 1e-4
    #[arg(long, value_name = "S", default_value_t = 0.5, allow_negative_numbers = true)]
    #[arg(value_parser = values::scale)]
    tolerance_scale: f32,
    #[command(flatten)]
    effort: Effort,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
    /// Show no progress, and print nothing but what --json asks for
    #[arg(long)]
    quiet: bool,
}

/// A checked `mip`.
#[derive(Debug)]
pub(crate) struct Mip {
    pub(crate) input: PathBuf,
    pub(crate) output: PathBuf,
    pub(crate) options: PyramidOptions,
    pub(crate) effort: Effort,
    pub(crate) json: bool,
    pub(crate) quiet: bool,
}

impl From<MipFlags> for Mip {
    fn from(flags: MipFlags) -> Self {
        let MipFlags { input, output, levels, tolerance_scale, effort, json, quiet } = flags;
        let options = PyramidOptions::default().with_tolerance_scale(tolerance_scale);
        let options = levels.map_or(options, |levels| options.with_levels(levels));
        Self { input, output, options, effort, json, quiet }
    }
}
