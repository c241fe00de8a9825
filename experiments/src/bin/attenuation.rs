//! Measures attenuation maps and several traced views: `attenuation OUT [FOLDER…] [--every N]
//! [--small]` writes `results/attenuation.md` and its pictures in the folder OUT. Of scenes of
//! other programs, each a folder, every Nth point is asked.

use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use dsm_experiments::attenuation::{Effort, page};
use dsm_experiments::prefilter::page::Compared;

fn main() -> Result<()> {
    let (mut every, mut effort, mut folders) = (1, Effort::full(), Vec::new());
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--every" => every = arguments.next().context("a number is missing")?.parse()?,
            "--small" => effort = Effort::small(),
            _ => folders.push(PathBuf::from(argument)),
        }
    }
    let Some((output, folders)) = folders.split_first() else {
        bail!("usage: attenuation OUT [FOLDER…] [--every N] [--small]");
    };
    let scenes: Result<Vec<_>> =
        folders.iter().map(|folder| Compared::open(folder, every)).collect();
    page(&effort, &scenes?)?.write(output)
}
