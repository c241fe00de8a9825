//! `merge`: several maps into one.

use std::io::{self, Write};

use anyhow::{Context, Result};
use deepshadow::files::{Limits, MapReader, MergeReport, merge};

use crate::args::Merge;
use crate::output::{printable, progress};
use crate::parallel::with_threads;

pub(crate) fn run(request: &Merge) -> Result<()> {
    let Merge { maps, output, tolerance, .. } = request;
    let open = |path| MapReader::open(path, &Limits::default());
    let maps = maps.iter().map(open).collect::<Result<Vec<_>, _>>()?;
    let report = with_threads(request.effort.threads, || {
        let bar = progress::bar(0, "merging".to_owned(), request.quiet);
        let merged = merge(&maps, output, *tolerance, |done, of| {
            bar.set_length(of);
            bar.set_position(done);
        });
        bar.finish_and_clear();
        Ok(merged?)
    })?;
    if request.quiet {
        return Ok(());
    }
    let merged = MapReader::open(output, &Limits::default()).context("reading what was written")?;
    let metadata = merged.metadata();
    let mut lines = vec![format!(
        "{}: {} × {} pixels, {}, {} bytes",
        printable(&output.to_string_lossy()),
        metadata.width,
        metadata.height,
        if metadata.channels == 1 { "mono" } else { "RGB" },
        merged.container().file_length()
    )];
    match report {
        MergeReport::Multiplied { tolerance, lost_levels, .. } => {
            let (count, epsilon) = (maps.len(), tolerance.epsilon());
            lines.push(format!("  the product of {count} maps, within {epsilon:.6}"));
            if lost_levels > 0 {
                lines.push(format!("  lost: {lost_levels} smaller levels"));
            }
        }
        _ => lines.push(format!("  put together of {} crops", maps.len())),
    }
    lines.push(String::new());
    Ok(io::stdout().write_all(lines.join("\n").as_bytes())?)
}
