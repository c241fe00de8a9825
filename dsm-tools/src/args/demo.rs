//! The switches of `demo`.

use std::path::PathBuf;

use clap::Args;

const EXAMPLES: &str = "\
Examples:
  dsm-tools demo --out hair";

/// Shows what the program does: bakes a ball of hair and looks into the map
///
/// Bakes builtin:hairball, adds the mip levels, verifies the file, plots a
/// pixel, draws the transmittance half way through, renders the ball
/// without and with the shadow it casts on itself, and says how long each step
/// took.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct DemoFlags {
    /// The folder to write to; made if it is not there
    #[arg(long, value_name = "DIR", default_value = "demo")]
    out: PathBuf,
    /// Show no progress, and print nothing
    #[arg(long)]
    quiet: bool,
}

/// A checked `demo`.
#[derive(Debug)]
pub(crate) struct Demo {
    pub(crate) folder: PathBuf,
    pub(crate) quiet: bool,
}

impl From<DemoFlags> for Demo {
    fn from(DemoFlags { out, quiet }: DemoFlags) -> Self {
        Self { folder: out, quiet }
    }
}
