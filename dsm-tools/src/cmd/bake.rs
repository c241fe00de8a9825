//! `bake`: the shadow map of a scene's light.

use std::io::{self, Write};
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};
use deepshadow::files::Attribute;
use deepshadow::scene::{Scene, open_scene};
use deepshadow::visibility::BakeProgress;
use deepshadow::{BakeReport, bake};
use indicatif::ProgressBar;

use crate::args::Bake;
use crate::interrupt::Interrupt;
use crate::output::{printable, progress};
use crate::parallel::with_threads;

pub(crate) fn run(request: &Bake) -> Result<()> {
    let started = Instant::now();
    let scene = open_scene(&request.scene)?;
    let opened = started.elapsed();
    let report = with_threads(request.effort.threads, || {
        let name = request.scene.to_string_lossy();
        bake_scene(&scene, &name, request.settings.clone(), &request.output, request.quiet)
    })?;
    if request.quiet {
        return Ok(());
    }
    let [width, height] = request.settings.resolution;
    let [left, top, right, bottom] = request.settings.crop.unwrap_or([0, 0, width, height]);
    let mut lines = format!(
        "{}: {} × {} pixels, {}, tolerance {}, {} bytes\n  \
         {} samples met {} surfaces and stretches of media\n  \
         scene {:.2} s, bake {:.2} s\n",
        printable(&request.output.to_string_lossy()),
        right - left,
        bottom - top,
        if report.channels == 1 { "mono" } else { "RGB" },
        report.tolerance,
        report.bytes,
        report.samples,
        report.hits,
        opened.as_secs_f64(),
        (started.elapsed() - opened).as_secs_f64(),
    );
    if report.cut_pixels > 0 {
        let cut = report.cut_pixels;
        lines += &format!("  {cut} pixels have more layers than --layers keeps\n");
    }
    Ok(io::stdout().write_all(lines.as_bytes())?)
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
    settings.software = concat!("dsm-tools ", env!("CARGO_PKG_VERSION")).to_owned();
    let [open, close] = scene.shutter;
    for (key, value) in [
        ("bakeScene", name.to_owned()),
        ("bakeSeed", settings.seed.to_string()),
        ("bakeShutter", format!("{open} {close}")),
    ] {
        settings = settings.with_attribute(key, Attribute::string(&value));
    }
    let watch = Watch::start(quiet)?;
    let baked = bake(scene, &scene.light, &settings, output, |progress| watch.at(progress));
    watch.bar.finish_and_clear();
    baked.with_context(|| format!("baking {name}"))
}

/// Shows how far a bake has come, and breaks it off where that is asked.
struct Watch {
    bar: ProgressBar,
    interrupt: Interrupt,
    started: Instant,
}

impl Watch {
    fn start(quiet: bool) -> Result<Self> {
        let bar = progress::bar(0, "baking".to_owned(), quiet);
        Ok(Self { bar, interrupt: Interrupt::listen()?, started: Instant::now() })
    }

    fn at(&self, BakeProgress { done, tiles }: BakeProgress) -> ControlFlow<()> {
        let rate = done as f64 / self.started.elapsed().as_secs_f64();
        self.bar.set_length(tiles);
        self.bar.set_position(done);
        self.bar.set_message(format!("baking, {done} of {tiles} tiles, {rate:.1} a second"));
        if self.interrupt.is_asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}
