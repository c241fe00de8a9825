//! `mip`: a map with the levels of its pyramid.

use std::io::{self, Write};

use anyhow::{Context, Result};
use deepshadow::files::{Limits, MapReader, mip};

use crate::args::Mip;
use crate::output::{printable, progress};
use crate::parallel::with_threads;

pub(crate) fn run(request: &Mip) -> Result<()> {
    let Mip { input, output, options, quiet, .. } = request;
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
    if *quiet {
        return Ok(());
    }
    let written = MapReader::open(output, &Limits::default())?;
    let [width, height] = [map.metadata().width, map.metadata().height];
    let (levels, bytes) = (written.levels().len(), written.container().file_length());
    let plural = if levels == 1 { "" } else { "s" };
    let name = printable(&output.to_string_lossy());
    let line =
        format!("{name}: {width} × {height} pixels, {levels} level{plural}, {bytes} bytes\n");
    Ok(io::stdout().write_all(line.as_bytes())?)
}
