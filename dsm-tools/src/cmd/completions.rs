//! `completions`: what a shell completes the command line with.

use std::io::{self, Write};

use anyhow::Result;
use clap_complete::generate;

use crate::args::{self, Completions};

pub(crate) fn run(request: &Completions) -> Result<()> {
    // Written at once: the generator ends the program if a pipe is closed.
    let mut script = Vec::new();
    generate(request.shell, &mut args::program(), "dsm-tools", &mut script);
    Ok(io::stdout().write_all(&script)?)
}
