//! `bake`: the shadow map of a scene's light, or a prefiltered one of another map.

use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};
use deepshadow::files::deep_exr::Selection;
use deepshadow::files::{Attribute, ConvertOptions, Limits, MapSource, convert};
use deepshadow::scene::Scene;
use deepshadow::scene::detail::{frame_path, open_scene_with};
use deepshadow::visibility::Progress;
use deepshadow::{BakeReport, Kind, ShadowMap, bake};
use serde::Serialize;

use crate::args::{Bake, is_exr};
use crate::in_map::empty_is;
use crate::memory;
use crate::output::limit;
use crate::output::progress::Watch;
use crate::output::stated::StatedReport;
use crate::output::warnings::Warnings;
use crate::output::written::{Written, channels_name};
use crate::parallel::with_threads;

/// What headers say that they were written by.
const SOFTWARE: &str = concat!("dsm-tools ", env!("CARGO_PKG_VERSION"));

pub(crate) fn run(request: &Bake) -> Result<()> {
    let started = Instant::now();
    let mut warnings = Warnings::new(request.strict);
    let mut settings = request.settings.clone();
    let (report, opened) = if request.is_of_map() {
        let opened = started.elapsed();
        let report = with_threads(request.effort.threads, || of_map(request, &mut settings))?;
        (report, opened)
    } else {
        let scene = open_scene_with(&request.scene, &request.scene_options)?;
        let opened = started.elapsed();
        warnings.extend(scene.warnings());
        if request.finds_resolution {
            settings.resolution = settings.kind.resolution_for(&scene);
        }
        let report = with_threads(request.effort.threads, || {
            let frame = request.scene_options.frame;
            let path = match frame {
                Some(frame) => frame_path(&request.scene, frame),
                None => request.scene.clone(),
            };
            let mut settings = settings.clone();
            if let Some(frame) = frame {
                let frame = Attribute::string(&frame.to_string());
                settings = settings.with_attribute("bakeFrame", frame);
            }
            let name = path.to_string_lossy();
            bake_scene(&scene, &name, settings, &request.output, request.quiet)
        })?;
        warnings.extend(doubts(&scene, &settings, &report));
        (report, opened)
    };
    let stated = stated(&request.output, &settings)?;
    let details = Details {
        tolerance: report.tolerance,
        stated,
        samples: report.samples,
        hits: report.hits,
        cut_pixels: report.cut_pixels,
        gained: report.gained,
        scene_s: opened.as_secs_f64(),
        bake_s: (started.elapsed() - opened).as_secs_f64(),
        peak_bytes: memory::peak(),
        warnings: &warnings,
    };
    let Details { tolerance, samples, hits, cut_pixels, scene_s, bake_s, .. } = details;
    let [width, height] = settings.resolution;
    let [left, top, right, bottom] = settings.crop.unwrap_or([0, 0, width, height]);
    // 1 or 3.
    let channels = report.channels as u8;
    let cut = limit::told(settings.kind, cut_pixels, report.gained.map(f64::from));
    let tile = settings.tile_size;
    let smaller = report.smaller_tiles.map(|size| {
        format!(
            "tiles of {size} × {size} pixels: readers would not accept what {tile} × {tile} hold"
        )
    });
    Written {
        output: &request.output,
        width: right - left,
        height: bottom - top,
        channels,
        bytes: report.bytes,
        details,
        notes: cut.into_iter().chain(smaller).collect(),
        summary: format!("{}, tolerance {tolerance}", channels_name(channels)),
        lines: [format!("{samples} samples met {hits} surfaces and stretches of media")]
            .into_iter()
            .chain(stated.and_then(|stated| stated.about_depths()))
            .chain([format!("scene {scene_s:.2} s, bake {bake_s:.2} s")])
            .collect(),
    }
    .print(request.json, request.quiet)?;
    warnings.finish()
}

/// A prefiltered map of a map, or of a deep image by way of one.
fn of_map(request: &Bake, settings: &mut deepshadow::Bake) -> Result<BakeReport> {
    let path = &request.scene;
    let folder = tempfile::tempdir().context("cannot make a folder for the map")?;
    let map = if is_exr(path) {
        let map = folder.path().join("map.dsm");
        let mut image = MapSource::open(path, Selection::default(), &Limits::default())?;
        let exact = ConvertOptions::default();
        convert(&mut image, &map, &exact, |_| ControlFlow::Continue(()))?;
        map
    } else {
        path.clone()
    };
    let map = ShadowMap::open(map)?;
    settings.resolution = map.size();
    settings.software = SOFTWARE.to_owned();
    Ok(map.prefilter(settings, &request.output)?)
}

/// What may not be meant by a bake.
pub(crate) fn doubts(
    scene: &Scene,
    settings: &deepshadow::Bake,
    report: &BakeReport,
) -> Vec<String> {
    let mut doubts = Vec::new();
    // Of a whole map: parts of one are often empty.
    if report.hits == 0 && settings.crop.is_none() {
        let is = empty_is(settings.kind.name());
        doubts.push(format!("no sample met anything: the map is {is}"));
    }
    if settings.kind.is_layered() && scene.is_moving() && settings.samples.unwrap_or(1) == 1 {
        let kind = settings.kind.name();
        let has_times = [Kind::FRAGMENTS, Kind::LAYERS, Kind::MTSM].contains(&settings.kind);
        let more = if has_times { ": --samples N takes it at N times" } else { "" };
        doubts.push(format!("what moves is in a map of kind {kind} as it is at mid-shutter{more}"));
    }
    doubts
}

/// What the map states of level 0, of kinds that state an error.
fn stated(path: &Path, settings: &deepshadow::Bake) -> Result<Option<StatedReport>> {
    if settings.kind.is_layered() {
        return Ok(None);
    }
    let stated = ShadowMap::open(path)?.stated_errors()?;
    Ok(stated.first().copied().map(StatedReport::from))
}

/// The command's part of the JSON document.
#[derive(Clone, Copy, Serialize)]
struct Details<'a> {
    tolerance: f32,
    #[serde(flatten)]
    stated: Option<StatedReport>,
    samples: u64,
    /// Surfaces and stretches of media that the samples met.
    hits: u64,
    /// Pixels of a layered map with more layers than were kept.
    cut_pixels: u64,
    /// The most light that they let through too much between the layers that became one, or
    /// behind those that are left, and the mean over all pixels.
    gained: [f32; 2],
    /// Seconds to open the scene.
    scene_s: f64,
    bake_s: f64,
    /// Resident memory at its peak, in bytes, where the system tells.
    peak_bytes: Option<u64>,
    /// What the scene's files hold that was not understood, and what may not be meant.
    warnings: &'a Warnings,
}

/// Bakes a scene on the current pool, with a progress bar, until somebody
/// interrupts it. The header says what was baked.
pub(crate) fn bake_scene(
    scene: &Scene,
    name: &str,
    mut settings: deepshadow::Bake,
    output: &Path,
    quiet: bool,
) -> Result<BakeReport> {
    settings.software = SOFTWARE.to_owned();
    let [open, close] = scene.shutter;
    for (key, value) in [
        ("bakeScene", name.to_owned()),
        ("bakeSeed", settings.seed.to_string()),
        ("bakeShutter", format!("{open} {close}")),
    ] {
        settings = settings.with_attribute(key, Attribute::string(&value));
    }
    let (watch, started) = (Watch::start("baking", quiet)?, Instant::now());
    let baked = bake(scene, &scene.light, &settings, output, |progress| {
        let Progress { done, total, .. } = progress;
        let rate = done as f64 / started.elapsed().as_secs_f64();
        watch.set_message(format!("baking, {done} of {total} tiles, {rate:.1} a second"));
        watch.at(progress)
    });
    drop(watch);
    baked.with_context(|| format!("baking {name}"))
}
