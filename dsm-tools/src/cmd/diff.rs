//! `diff`: how far two maps are apart.

use std::io::{self, BufWriter, Write};

use anyhow::{Result, anyhow};
use deepshadow::files::detail::{MapDifference, WorstPixel, compare_levels};
use deepshadow::files::{Error, Limits, MapSource};
use serde::Serialize;

use crate::args::Diff;
use crate::output::progress::Watch;
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
    let mut output = BufWriter::new(io::stdout().lock());
    if request.json {
        serde_json::to_writer(&mut output, &outcome(&difference)).map_err(io::Error::from)?;
        writeln!(output)?;
    } else {
        write_text(&difference, &mut output)?;
    }
    Ok(output.flush()?)
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
