//! Measures coherent sampling: `coherence OUT [FOLDER…] [--every N] [--small]` writes
//! `results/coherence.md` and its picture in the folder OUT. Of scenes of other programs, each a
//! folder, every Nth point is asked.

use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use dsm_experiments::coherence::{Effort, page};
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
        bail!("usage: coherence OUT [FOLDER…] [--every N] [--small]");
    };
    // This thread alone, so that its time is all there is.
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global()?;
    let scenes: Result<Vec<_>> =
        folders.iter().map(|folder| Compared::open(folder, every)).collect();
    page(&effort, &scenes?)?.write(output)
}
