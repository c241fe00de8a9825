//! `merge`: several maps into one.

use anyhow::{Context, Result};
use deepshadow::files::{Limits, MapReader, MergeReport, Metadata, merge};
use serde::Serialize;

use crate::args::Merge;
use crate::output::progress::Watch;
use crate::output::written::{Written, channels_name};
use crate::parallel::with_threads;

/// The command's part of the JSON document.
#[derive(Serialize)]
struct Details {
    /// How the maps became one: `product` or `crops`.
    operation: &'static str,
    maps: usize,
    tolerance: f32,
}

pub(crate) fn run(request: &Merge) -> Result<()> {
    let Merge { maps, output, tolerance, .. } = request;
    let open = |path| MapReader::open(path, &Limits::default());
    let maps = maps.iter().map(open).collect::<Result<Vec<_>, _>>()?;
    let report = with_threads(request.effort.threads, || {
        let watch = Watch::start("merging", request.quiet)?;
        let merged = merge(&maps, output, *tolerance, |progress| watch.at(progress));
        drop(watch);
        Ok(merged?)
    })?;
    if request.quiet && !request.json {
        return Ok(());
    }
    let merged = MapReader::open(output, &Limits::default()).context("reading what was written")?;
    let &Metadata { width, height, channels, info, .. } = merged.metadata();
    let count = maps.len();
    let mut notes = Vec::new();
    let (operation, line) = match report {
        MergeReport::Multiplied { tolerance, lost_levels, .. } => {
            if lost_levels > 0 {
                notes.push(format!("lost: {lost_levels} smaller levels"));
            }
            let epsilon = tolerance.epsilon();
            ("product", format!("the product of {count} maps, within {epsilon:.6}"))
        }
        _ => ("crops", format!("put together of {count} crops")),
    };
    Written {
        output,
        width,
        height,
        channels,
        bytes: merged.container().file_length(),
        details: Details { operation, maps: count, tolerance: info.tolerance.epsilon() },
        notes,
        summary: channels_name(channels).to_owned(),
        lines: vec![line],
    }
    .print(request.json, request.quiet)
}
