//! The switches of `man`.

use std::path::PathBuf;

use clap::Args;

const EXAMPLES: &str = "\
Examples:
  dsm-tools man ~/.local/share/man/man1";

/// Writes the manual pages of the program and of each of its commands
///
/// They are dsm-tools.1 and dsm-tools-COMMAND.1: `man dsm-tools-bake` shows one if the folder is
/// where man looks.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct ManFlags {
    /// The folder to write to; made if it is not there
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

/// A checked `man`.
#[derive(Debug)]
pub(crate) struct Man {
    pub(crate) folder: PathBuf,
}

impl From<ManFlags> for Man {
    fn from(ManFlags { folder }: ManFlags) -> Self {
        Self { folder }
    }
}
