//! `man`: the manual pages.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use clap::Command;
use deepshadow::files::detail::replace_file;

use crate::args::{self, Man};

pub(crate) fn run(request: &Man) -> Result<()> {
    let folder = &request.folder;
    fs::create_dir_all(folder).with_context(|| format!("making {}", folder.display()))?;
    // The version's commit changes with each build, and no page should.
    let version = env!("CARGO_PKG_VERSION");
    let mut program = args::program().disable_help_subcommand(true).version(version);
    program.build();
    for command in program.get_subcommands() {
        write_page(folder, command.clone().version(version))?;
    }
    write_page(folder, program)
}

/// Writes a command's page, under the name that the built command is shown by.
fn write_page(folder: &Path, command: Command) -> Result<()> {
    let name = command.get_display_name().unwrap_or(command.get_name()).to_owned();
    let mut page = Vec::new();
    clap_mangen::Man::new(command).render(&mut page)?;
    Ok(replace_file(&folder.join(format!("{name}.1")), &page)?)
}
