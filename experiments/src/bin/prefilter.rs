//! Measures prefiltered maps on scenes of other programs:
//! `prefilter OUT FOLDER… [--every N] [--runs N]` writes `results/prefilter.md` in the
//! folder OUT.

use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use dsm_experiments::prefilter::page::{Compared, page};

fn main() -> Result<()> {
    let (mut every, mut runs, mut folders) = (1, 2, Vec::new());
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--every" => every = arguments.next().context("a number is missing")?.parse()?,
            "--runs" => runs = arguments.next().context("a number is missing")?.parse()?,
            _ => folders.push(PathBuf::from(argument)),
        }
    }
    if folders.len() < 2 {
        bail!("usage: prefilter OUT FOLDER… [--every N] [--runs N]");
    }
    // This thread alone, so that its time is all there is.
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global()?;
    let scenes: Result<Vec<_>> =
        folders[1..].iter().map(|folder| Compared::open(folder, every)).collect();
    page(&scenes?, runs)?.write(&folders[0])
}
