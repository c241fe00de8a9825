//! `bake`: the shadow map of a scene's light.

use std::io::{self, Write};
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};
use dsm_core::{BakeProgress, BakeSettings, Baker, LightExtent, Rgb, Transmittance};
use dsm_io::{Attribute, BakeOptions, BakeReport, Metadata, bake};
use dsm_scene::{Scene, SceneRasterizer, open_scene};
use indicatif::ProgressBar;

use super::bake_layers::LayersJob;
use crate::args::Bake;
use crate::interrupt::Interrupt;
use crate::output::{printable, progress};
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
    let report = with_threads(request.effort.threads, || match request.layers {
        None => job.run(&request.output),
        Some(layers) => LayersJob { job: &job, layers }.run(&request.output),
    })?;
    if request.quiet {
        return Ok(());
    }
    let [left, top, right, bottom] = request.settings.window();
    let lines = format!(
        "{}: {} × {} pixels, {}, tolerance {}, {} bytes\n  \
         {} samples met {} surfaces and stretches of media\n  \
         scene {:.2} s, bake {:.2} s\n",
        printable(&request.output.to_string_lossy()),
        right - left,
        bottom - top,
        if job.is_coloured() { "RGB" } else { "mono" },
        request.settings.tolerance().epsilon(),
        report.bytes,
        job.samples() * request.layers.map_or(1, |layers| layers.samples().into()),
        report.hits,
        opened.as_secs_f64(),
        (started.elapsed() - opened).as_secs_f64(),
    );
    io::stdout().write_all(lines.as_bytes())?;
    if report.cut_pixels > 0 {
        let cut_pixels = report.cut_pixels;
        writeln!(io::stdout(), "  {cut_pixels} pixels have more layers than --layers keeps")?;
    }
    Ok(())
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
