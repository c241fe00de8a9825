//! The switches of `completions`.

use clap::Args;
use clap_complete::Shell;

const EXAMPLES: &str = "\
Examples:
  dsm-tools completions bash
  dsm-tools completions zsh
  dsm-tools completions fish";

/// Prints what a shell completes the program's commands and switches with
///
/// bash: save it as ~/.local/share/bash-completion/completions/dsm-tools; zsh: as _dsm-tools in
/// a folder of $fpath; fish: as ~/.config/fish/completions/dsm-tools.fish.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct CompletionsFlags {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

/// A checked `completions`.
#[derive(Debug)]
pub(crate) struct Completions {
    pub(crate) shell: Shell,
}

impl From<CompletionsFlags> for Completions {
    fn from(CompletionsFlags { shell }: CompletionsFlags) -> Self {
        Self { shell }
    }
}
