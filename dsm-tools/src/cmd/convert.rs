//! `convert`: from an image or a map to a map, from a map to an image.

use std::io::{self, Write};

use anyhow::{Context, Result};
use deepshadow::files::{ExportOptions, ExportReport, Limits, MapSource, convert, export_deep_exr};

use crate::args::{Convert, ConvertTarget};
use crate::output::{printable, progress};
use crate::parallel::with_threads;

/// Channels that a map keeps, as depth and opacity.
const KEPT: [&str; 9] = ["Z", "ZBack", "A", "AR", "AG", "AB", "RA", "GA", "BA"];

pub(crate) fn run(request: &Convert) -> Result<()> {
    let Convert { input, output, part, .. } = request;
    let mut source = MapSource::open(input, part.as_deref(), &Limits::default())?;
    let [width, height] = source.size();
    let told = with_threads(request.effort.threads, || {
        let bar = progress::bar(height.into(), "converting".to_owned(), request.quiet);
        let rows_done = |rows: u32| bar.set_position(rows.into());
        let done = match &request.target {
            ConvertTarget::Map(options) => {
                convert(&mut source, output, options, rows_done).map(|report| report.lines())
            }
            ConvertTarget::Image(options) => {
                export_deep_exr(&mut source, output, options, rows_done)
                    .map(|report| written(&report, options))
            }
        };
        bar.finish_and_clear();
        done.with_context(|| format!("converting {}", input.display()))
    })?;
    if request.quiet {
        return Ok(());
    }
    let bytes = output.metadata().map_or(0, |metadata| metadata.len());
    let mut lines = vec![format!(
        "{}: {width} × {height} pixels, {}, {bytes} bytes",
        printable(&output.to_string_lossy()),
        if source.channels() == 1 { "mono" } else { "RGB" },
    )];
    lines.extend(lost(&source).into_iter().chain(told).map(|line| format!("  {line}")));
    lines.push(String::new());
    Ok(io::stdout().write_all(lines.join("\n").as_bytes())?)
}

/// What an image holds, how far it is off, and what it does not have.
fn written(report: &ExportReport, options: &ExportOptions) -> Vec<String> {
    let ExportReport { samples, max_samples, achieved, total, left_out, .. } = report;
    let stated = options.error.epsilon();
    let mut lines = vec![
        format!("{samples} samples, at most {max_samples} a pixel"),
        format!("off by {achieved:.2e} from the map, {stated:e} allowed; {total:.6} in all"),
    ];
    if achieved > &f64::from(stated) {
        lines.push("more than allowed: half opacities are too coarse for that".to_owned());
    }
    if !left_out.is_empty() {
        lines.push(format!("lost: attributes {}", printable(&left_out.join(", "))));
    }
    lines
}

/// What is in the source and has no place in the map.
fn lost(source: &MapSource) -> Vec<String> {
    let mut lines = Vec::new();
    match source {
        MapSource::Map(map) => {
            let levels = map.levels().len() - 1;
            if levels > 0 {
                lines.push(format!("lost: {levels} smaller levels"));
            }
        }
        MapSource::Image(image) => {
            let header = image.header();
            let names = header.channels.iter().map(|channel| channel.name.as_str());
            let names: Vec<_> = names.filter(|name| !KEPT.contains(name)).collect();
            if !names.is_empty() {
                lines.push(format!("lost: channels {}", printable(&names.join(", "))));
            }
            if header.has_levels {
                lines.push("lost: the levels above the first".to_owned());
            }
        }
    }
    lines
}
