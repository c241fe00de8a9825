//! `convert`: from an image or a map to a map, from a map to an image.

use anyhow::{Context, Result};
use deepshadow::ShadowMap;
use deepshadow::files::detail::file_length;
use deepshadow::files::{
    ExportOptions, ExportReport, Limits, MapSource, convert, convert_to_size, export_deep_exr,
};
use serde::Serialize;

use crate::args::{Convert, ConvertTarget};
use crate::in_map::{is_empty, is_part};
use crate::input::Input;
use crate::output::printable;
use crate::output::progress::Watch;
use crate::output::stated::StatedReport;
use crate::output::warnings::Warnings;
use crate::output::written::{Written, channels_name};
use crate::parallel::with_threads;

/// The command's part of the JSON document.
#[derive(Serialize)]
struct Details<'a> {
    /// Samples of the image that was read or written; of a map 0.
    samples: u64,
    #[serde(flatten)]
    image: Option<ImageDetails>,
    /// What a map states of level 0.
    #[serde(flatten)]
    stated: Option<StatedReport>,
    warnings: &'a Warnings,
}

/// What `--json` tells of an image that was written.
#[derive(Serialize)]
struct ImageDetails {
    /// The most samples of a pixel.
    max_samples: u64,
    /// How far the image is off from the map, how far it may be, and how far it
    /// may be off from what the map was made of.
    error: f64,
    allowed: f32,
    total_error: f64,
}

pub(crate) fn run(request: &Convert) -> Result<()> {
    let Convert { output, selection, .. } = request;
    let input = Input::new(&request.input)?;
    let input = input.path();
    let mut source = MapSource::open(input, selection, &Limits::default())?;
    let [width, height] = source.size();
    let mut notes = lost(&source);
    let ((samples, image), mut lines) = with_threads(request.effort.threads, || {
        let watch = Watch::start("converting", request.quiet)?;
        let at = |progress| watch.at(progress);
        let done = match &request.target {
            ConvertTarget::Map(options, target_size) => {
                let done = match *target_size {
                    None => convert(&mut source, output, options, at).map(|done| (done, None)),
                    Some(bytes) => convert_to_size(&mut source, output, options, bytes, at)
                        .map(|(done, found)| (done, Some(found))),
                };
                done.map(|(report, found)| {
                    notes.extend(report.lines().iter().map(|line| printable(line)));
                    let told = found.map(|found| format!("tolerance {} found", found.epsilon()));
                    ((report.samples, None), told.into_iter().collect())
                })
            }
            ConvertTarget::Image(options) => export_deep_exr(&mut source, output, options, at)
                .map(|report| written(&report, options, &mut notes)),
        };
        drop(watch);
        done.with_context(|| format!("converting {}", input.display()))
    })?;
    let (mut warnings, mut stated) = (Warnings::new(request.strict), None);
    let is_empty = match request.target {
        ConvertTarget::Map(..) => {
            let map = ShadowMap::open(output)?;
            stated = map.stated_errors()?.first().copied().map(StatedReport::from);
            lines.extend(stated.and_then(|stated| stated.about_depths()));
            is_empty(&map)? && !is_part(&map)
        }
        ConvertTarget::Image(_) => samples == 0,
    };
    if is_empty {
        warnings.add("no pixel holds anything: it is lit everywhere");
    }
    let details = Details { samples, image, stated, warnings: &warnings };
    let channels = source.channels();
    Written {
        output,
        width,
        height,
        channels,
        bytes: file_length(output).unwrap_or(0),
        details,
        notes,
        summary: channels_name(channels).to_owned(),
        lines,
    }
    .print(request.json, request.quiet)?;
    warnings.finish()
}

/// What an image holds and how far it is off, for both readers; what it does not
/// have goes to the notes.
fn written(
    report: &ExportReport,
    options: &ExportOptions,
    notes: &mut Vec<String>,
) -> ((u64, Option<ImageDetails>), Vec<String>) {
    let ExportReport { samples, max_samples, achieved, total, left_out, .. } = report;
    let stated = options.error.epsilon();
    let lines = vec![
        format!("{samples} samples, at most {max_samples} a pixel"),
        format!("off by {achieved:.2e} from the map, {stated:e} allowed; {total:.6} in all"),
    ];
    let image = ImageDetails {
        max_samples: u64::from(*max_samples),
        error: *achieved,
        allowed: stated,
        total_error: *total,
    };
    if achieved > &f64::from(stated) {
        notes.push("more than allowed: half opacities are too coarse for that".to_owned());
    }
    if !left_out.is_empty() {
        notes.push(format!("lost: attributes {}", printable(&left_out.join(", "))));
    }
    ((*samples, Some(image)), lines)
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
            // Beside the opacities of all colours stands their mean.
            let is_mean = |name: &str| name == "A" && header.read.opacity.len() == 3;
            let is_lost = |name: &&str| !header.read.contains(name) && !is_mean(name);
            let names: Vec<_> = names.filter(is_lost).collect();
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
