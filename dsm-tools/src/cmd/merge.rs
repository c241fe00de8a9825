//! `merge`: several maps into one.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use deepshadow::files::{MergeReport, Metadata};
use deepshadow::{ShadowMap, merge};
use serde::Serialize;

use crate::args::Merge;
use crate::memory;
use crate::output::progress::Watch;
use crate::output::written::{Written, channels_name};
use crate::parallel::with_threads;
use crate::plan::found::FoundPart;
use crate::plan::job::Plan;
use crate::plan::parts;

/// The command's part of the JSON document.
#[derive(Serialize)]
struct Details {
    /// How the maps became one: `product` or `crops`.
    operation: &'static str,
    maps: usize,
    /// Resident memory at its peak, in bytes, where the system tells.
    peak_bytes: Option<u64>,
    tolerance: f32,
}

/// Refuses maps that are not the parts of one of a plan, each once.
fn check_expected(plan: &Plan, maps: &[PathBuf], output: &Path) -> Result<()> {
    let found = maps.iter().map(|path| Ok((path.clone(), FoundPart::open(path)?.0)));
    let found = found.collect::<Result<Vec<_>>>()?;
    let map = parts::expected_map(plan, &output.to_string_lossy(), &found);
    parts::check(plan, map, &found)
}

pub(crate) fn run(request: &Merge) -> Result<()> {
    let Merge { maps, output, tolerance, .. } = request;
    if let Some(path) = &request.expect {
        check_expected(&Plan::read(path)?, maps, output)?;
    }
    let report = with_threads(request.effort.threads, || {
        let watch = Watch::start("merging", request.quiet)?;
        let merged = merge(maps, output, *tolerance, |progress| watch.at(progress));
        drop(watch);
        Ok(merged?)
    })?;
    if request.quiet && !request.json {
        return Ok(());
    }
    let merged = ShadowMap::open(output).context("reading what was written")?;
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
        details: Details {
            operation,
            maps: count,
            peak_bytes: memory::peak(),
            tolerance: info.tolerance.epsilon(),
        },
        notes,
        summary: channels_name(channels).to_owned(),
        lines: vec![line],
    }
    .print(request.json, request.quiet)
}
