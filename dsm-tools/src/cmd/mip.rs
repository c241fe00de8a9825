//! `mip`: a map with the levels of its pyramid.

use anyhow::{Context, Result};
use dsm_io::{Limits, MapReader, Metadata, mip};
use serde::Serialize;

use crate::args::Mip;
use crate::output::progress;
use crate::output::written::Written;
use crate::parallel::with_threads;

/// What `--json` tells besides the file.
#[derive(Serialize)]
struct Details {
    levels: usize,
}

pub(crate) fn run(request: &Mip) -> Result<()> {
    let Mip { input, output, options, json, quiet, .. } = request;
    let map = MapReader::open(input, &Limits::default())?;
    with_threads(request.effort.threads, || {
        let bar = progress::bar(0, "averaging".to_owned(), *quiet);
        let done = mip(&map, output, options, |done, tiles| {
            bar.set_length(tiles);
            bar.set_position(done);
        });
        bar.finish_and_clear();
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
        details: Details { levels },
        notes: Vec::new(),
        summary: format!("{levels} level{plural}"),
        lines: Vec::new(),
    }
    .print(*json, *quiet)
}
