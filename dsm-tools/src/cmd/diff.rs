//! `diff`: how far two maps are apart.

use std::io::{self, BufWriter, Write};
use std::path::Path;

use anyhow::{Result, anyhow};
use deepshadow::files::detail::{MapDifference, WorstPixel, compare_levels};
use deepshadow::files::{Error, Limits, MapSource};
use serde::Serialize;

use crate::args::Diff;
use crate::input::STREAM;
use crate::openable::Openable;
use crate::output::progress::Watch;
use crate::page::{Page, PageDifference, WorstPlace};
use crate::parallel::with_threads;

/// The JSON document.
#[derive(Serialize)]
struct Outcome {
    max: f64,
    mean: f64,
    worst: Option<Worst>,
}

#[derive(Serialize)]
struct Worst {
    level: u32,
    x: u32,
    y: u32,
    z: f32,
    channel: usize,
}

pub(crate) fn run(request: &Diff) -> Result<()> {
    let [a, b] = &request.files;
    let open = |path| MapSource::open(path, None, &Limits::default());
    let (mut one, mut other) = (open(a)?, open(b)?);
    let difference = with_threads(request.effort.threads, || {
        let watch = Watch::start("comparing", request.quiet)?;
        let compared = compare_levels(&mut one, &mut other, |progress| watch.at(progress));
        drop(watch);
        compared.map_err(|error| match error {
            // That names a file already.
            Error::File { .. } => anyhow!(error),
            error => anyhow!(error).context(format!("{} and {}", a.display(), b.display())),
        })
    })?;
    if let Some(file) = &request.html {
        let opened = [Openable::open(a)?, Openable::open(b)?];
        let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into();
        let maps = request.files.iter().zip(&opened).map(|(path, of)| (name(path), of.map()));
        let page = Page {
            maps: maps.collect(),
            difference: Some(page_difference(&difference)),
            limit: request.max_size,
        };
        page.write(file)?;
        if file.as_os_str() == STREAM {
            return Ok(());
        }
    }
    let mut output = BufWriter::new(io::stdout().lock());
    if request.json {
        serde_json::to_writer(&mut output, &outcome(&difference)).map_err(io::Error::from)?;
        writeln!(output)?;
    } else {
        write_text(&difference, &mut output)?;
    }
    Ok(output.flush()?)
}

fn page_difference(difference: &MapDifference) -> PageDifference {
    PageDifference {
        max: difference.max(),
        mean: difference.mean,
        worst: difference.worst.map(|WorstPixel { level, x, y, z, .. }| WorstPlace {
            level,
            x,
            y,
            z,
        }),
    }
}

fn outcome(difference: &MapDifference) -> Outcome {
    Outcome {
        max: difference.max(),
        mean: difference.mean,
        worst: difference.worst.map(|WorstPixel { level, x, y, z, channel, .. }| Worst {
            level,
            x,
            y,
            z,
            channel,
        }),
    }
}

fn write_text(difference: &MapDifference, output: &mut impl Write) -> io::Result<()> {
    match difference.worst {
        None => writeln!(output, "no difference"),
        Some(WorstPixel { level, x, y, z, channel, difference: max }) => {
            writeln!(
                output,
                "max {max:.9} at pixel ({x}, {y}) of level {level}, depth {z}, channel {channel}"
            )?;
            writeln!(output, "mean {:.9}", difference.mean)
        }
    }
}
