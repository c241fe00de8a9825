//! `convert`: from an image or a map to a map.

use std::io::{self, Write};

use anyhow::{Context, Result, bail};
use dsm_io::{ConvertOptions, ExrLayout, Limits, MapSource, convert};

use crate::args::Convert;
use crate::output::{printable, progress};
use crate::parallel::with_threads;

/// Channels that a map keeps, as depth and opacity.
const KEPT: [&str; 9] = ["Z", "ZBack", "A", "AR", "AG", "AB", "RA", "GA", "BA"];

pub(crate) fn run(request: &Convert) -> Result<()> {
    let Convert { input, output, part, .. } = request;
    if output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("exr")) {
        bail!("{}: writing .exr is not supported yet", output.display());
    }
    let mut source = MapSource::open(input, part.as_deref(), &Limits::default())?;
    let [width, height] = source.size();
    let options = ConvertOptions { tolerance: request.tolerance, write: request.write };
    let report = with_threads(request.effort.threads, || {
        let bar = progress::bar(height.into(), "converting".to_owned(), request.quiet);
        let done = convert(&mut source, output, &options, |rows| bar.set_position(rows.into()));
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
    lines.extend(lost(&source).into_iter().chain(report.lines()).map(|line| format!("  {line}")));
    lines.push(String::new());
    Ok(io::stdout().write_all(lines.join("\n").as_bytes())?)
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
            if let ExrLayout::Tiles { has_levels: true, .. } = header.layout {
                lines.push("lost: the levels above the first".to_owned());
            }
        }
    }
    lines
}
