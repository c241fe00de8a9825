//! `mip`: a map with the levels of its pyramid.

use anyhow::{Context, Result};
use deepshadow::files::{Limits, MapReader, Metadata, mip};
use serde::Serialize;

use crate::args::Mip;
use crate::memory;
use crate::output::progress::Watch;
use crate::output::written::Written;
use crate::parallel::with_threads;

/// The command's part of the JSON document.
#[derive(Serialize)]
struct Details {
    levels: usize,
    /// Resident memory at its peak, in bytes, where the system tells.
    peak_bytes: Option<u64>,
}

pub(crate) fn run(request: &Mip) -> Result<()> {
    let Mip { input, output, options, json, quiet, .. } = request;
    let map = MapReader::open(input, &Limits::default())?;
    with_threads(request.effort.threads, || {
        let watch = Watch::start("averaging", *quiet)?;
        let done = mip(&map, output, options, |progress| watch.at(progress));
        drop(watch);
        done.with_context(|| format!("averaging {}", input.display()))
    })?;
    if *quiet && !json {
        return Ok(());
    }
    let written = MapReader::open(output, &Limits::default())?;
    let levels = written.levels().len();
    let plural = if levels == 1 { "" } else { "s" };
    let &Metadata { width, height, channels, .. } = map.metadata();
    Written {
        output,
        width,
        height,
        channels,
        bytes: written.container().file_length(),
        details: Details { levels, peak_bytes: memory::peak() },
        notes: Vec::new(),
        summary: format!("{levels} level{plural}"),
        lines: Vec::new(),
    }
    .print(*json, *quiet)
}
