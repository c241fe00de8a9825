//! Arguments of programs that measure on scenes of other programs.

use std::path::PathBuf;

use anyhow::{Context, Result, bail};

use crate::prefilter::page::Compared;

/// What `NAME OUT [FOLDER…] [--every N] [--small]` asks for.
pub struct Arguments {
    /// The folder of documents that is written to.
    pub output: PathBuf,
    /// Scenes of other programs, each a folder, of which every Nth point is asked.
    pub compared: Vec<Compared>,
    /// As little as still shows the same.
    pub is_small: bool,
}

impl Arguments {
    /// The arguments of the program `name`.
    ///
    /// # Errors
    ///
    /// What is missing, or what a folder is not.
    pub fn of(name: &str) -> Result<Self> {
        let (mut every, mut is_small, mut folders) = (1, false, Vec::new());
        let mut arguments = std::env::args().skip(1);
        while let Some(argument) = arguments.next() {
            match argument.as_str() {
                "--every" => every = arguments.next().context("a number is missing")?.parse()?,
                "--small" => is_small = true,
                _ => folders.push(PathBuf::from(argument)),
            }
        }
        let Some((output, folders)) = folders.split_first() else {
            bail!("usage: {name} OUT [FOLDER…] [--every N] [--small]");
        };
        let compared = folders.iter().map(|folder| Compared::open(folder, every));
        Ok(Self { output: output.clone(), compared: compared.collect::<Result<_>>()?, is_small })
    }
}
