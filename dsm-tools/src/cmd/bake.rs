//! `bake`: the shadow map of a scene's light.

use std::io::{self, Write};
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};
use dsm_core::{BakeProgress, BakeSettings, Baker, Rgb, Transmittance};
use dsm_io::{Attribute, BakeOptions, BakeReport, Metadata, bake};
use dsm_scene::{Scene, SceneRasterizer, open_scene};

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
    let report = with_threads(request.effort.threads, || job.run(&request.output))?;
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
        job.samples(),
        report.hits,
        opened.as_secs_f64(),
        (started.elapsed() - opened).as_secs_f64(),
    );
    Ok(io::stdout().write_all(lines.as_bytes())?)
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
        let describe = |metadata: &mut Metadata| {
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
        };
        let interrupt = Interrupt::listen()?;
        let started = Instant::now();
        let bar = progress::bar(baker.settings().tile_count(), "baking".to_owned(), self.quiet);
        let samples_per_tile = self.samples() as f64 / baker.settings().tile_count() as f64;
        let watch = |BakeProgress { done, tiles }| {
            let rate = done as f64 * samples_per_tile / started.elapsed().as_secs_f64();
            bar.set_position(done);
            bar.set_message(format!("baking, {done} of {tiles} tiles, {rate:.2e} samples/s"));
            if interrupt.is_asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let done = bake(&baker, output, &self.options, describe, watch);
        bar.finish_and_clear();
        done.with_context(|| format!("baking {}", self.name))
    }
}
