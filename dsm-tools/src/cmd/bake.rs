//! `bake`: the shadow map of a scene's light.

use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};
use dsm_core::{BakeProgress, BakeSettings, Baker, LightExtent, Rgb, Transmittance};
use dsm_io::{Attribute, BakeOptions, BakeReport, Metadata, bake};
use dsm_scene::{Scene, SceneRasterizer, open_scene};
use indicatif::ProgressBar;
use serde::Serialize;

use super::bake_layers::LayersJob;
use crate::args::Bake;
use crate::interrupt::Interrupt;
use crate::output::progress;
use crate::output::written::{Written, channels_name};
use crate::parallel::with_threads;

pub(crate) fn run(request: &Bake) -> Result<()> {
    let started = Instant::now();
    let scene = open_scene(&request.scene)?;
    let opened = started.elapsed();
    let job = BakeJob {
        scene: &scene,
        name: &request.scene.to_string_lossy(),
        settings: request.settings.clone(),
        coloured: request.coloured,
        options: request.options,
        seed: request.seed,
        quiet: request.quiet,
    };
    let (report, cut_pixels) = with_threads(request.effort.threads, || match request.layers {
        None => job.run(&request.output).map(|report| (report, 0)),
        Some(layers) => LayersJob { job: &job, layers }.run(&request.output),
    })?;
    let details = Details {
        tolerance: request.settings.tolerance().epsilon(),
        samples: job.samples() * request.layers.map_or(1, |layers| layers.samples().into()),
        hits: report.hits,
        cut_pixels,
        scene_s: opened.as_secs_f64(),
        bake_s: (started.elapsed() - opened).as_secs_f64(),
    };
    let Details { tolerance, samples, hits, scene_s, bake_s, .. } = details;
    let [left, top, right, bottom] = request.settings.window();
    let channels = if job.is_coloured() { 3 } else { 1 };
    let cut = format!("{cut_pixels} pixels have more layers than --layers keeps");
    Written {
        output: &request.output,
        width: right - left,
        height: bottom - top,
        channels,
        bytes: report.bytes,
        details,
        notes: if cut_pixels > 0 { vec![cut] } else { Vec::new() },
        summary: format!("{}, tolerance {tolerance}", channels_name(channels)),
        lines: vec![
            format!("{samples} samples met {hits} surfaces and stretches of media"),
            format!("scene {scene_s:.2} s, bake {bake_s:.2} s"),
        ],
    }
    .print(request.json, request.quiet)
}

/// What `--json` tells besides the file.
#[derive(Clone, Copy, Serialize)]
struct Details {
    tolerance: f32,
    samples: u64,
    /// Surfaces and stretches of media that the samples met.
    hits: u64,
    /// Pixels of a layered map with more layers than were kept.
    cut_pixels: u64,
    /// Seconds to open the scene.
    scene_s: f64,
    bake_s: f64,
}

/// A scene and how its map is to be baked.
pub(crate) struct BakeJob<'a> {
    pub(crate) scene: &'a Scene,
    /// What the map says that it was baked from.
    pub(crate) name: &'a str,
    /// All but the camera.
    pub(crate) settings: BakeSettings,
    pub(crate) coloured: Option<bool>,
    pub(crate) options: BakeOptions,
    pub(crate) seed: u64,
    pub(crate) quiet: bool,
}

impl BakeJob<'_> {
    pub(crate) fn is_coloured(&self) -> bool {
        self.coloured.unwrap_or_else(|| self.scene.is_coloured())
    }

    /// Number of samples of the pixels that are baked.
    pub(crate) fn samples(&self) -> u64 {
        let [left, top, right, bottom] = self.settings.window();
        let pixels = u64::from(right - left) * u64::from(bottom - top);
        pixels * u64::from(self.settings.sampling.samples_per_pixel())
    }

    /// Bakes on the current pool.
    pub(crate) fn run(&self, output: &Path) -> Result<BakeReport> {
        if self.is_coloured() { self.bake::<Rgb>(output) } else { self.bake::<f32>(output) }
    }

    fn bake<T: Transmittance>(&self, output: &Path) -> Result<BakeReport> {
        let raster = self.scene.light.raster(self.settings.size)?;
        let source = SceneRasterizer::<T>::new(self.scene, raster)?;
        let camera = Some(raster.shadow_camera());
        let settings = BakeSettings { camera, ..self.settings.clone() };
        let light = self.scene.light.area()?.extent();
        let baker = Baker::<T, _>::new(source, settings)?;
        let watch = Watch::start(self, baker.settings().tile_count())?;
        let describe = |metadata: &mut Metadata| self.describe(light, metadata);
        let done = bake(&baker, output, &self.options, describe, |progress| watch.at(progress));
        watch.bar.finish_and_clear();
        done.with_context(|| format!("baking {}", self.name))
    }

    /// Says what the map was baked from.
    pub(crate) fn describe(&self, light: LightExtent, metadata: &mut Metadata) {
        metadata.software = concat!("dsm-tools ", env!("CARGO_PKG_VERSION")).to_owned();
        metadata.info.light = Some(light);
        let shutter = self.scene.shutter;
        for (name, value) in [
            ("bakeScene", self.name.to_owned()),
            ("bakeSeed", self.seed.to_string()),
            ("bakeShutter", format!("{} {}", shutter[0], shutter[1])),
        ] {
            metadata.attributes.insert(name.to_owned(), Attribute::string(&value));
        }
    }
}

/// Shows how far a bake has come, and breaks it off where that is asked.
pub(crate) struct Watch {
    pub(crate) bar: ProgressBar,
    interrupt: Interrupt,
    started: Instant,
    samples_per_tile: f64,
}

impl Watch {
    pub(crate) fn start(job: &BakeJob<'_>, tiles: u64) -> Result<Self> {
        Ok(Self {
            bar: progress::bar(tiles, "baking".to_owned(), job.quiet),
            interrupt: Interrupt::listen()?,
            started: Instant::now(),
            samples_per_tile: job.samples() as f64 / tiles as f64,
        })
    }

    pub(crate) fn at(&self, BakeProgress { done, tiles }: BakeProgress) -> ControlFlow<()> {
        let rate = done as f64 * self.samples_per_tile / self.started.elapsed().as_secs_f64();
        self.bar.set_position(done);
        self.bar.set_message(format!("baking, {done} of {tiles} tiles, {rate:.2e} samples/s"));
        if self.interrupt.is_asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}
