//! `render`: a scene under its light.

use std::io::{self, Write};
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use dsm_core::{
    AreaLight, BakeSettings, Bias, BiasSummary, Footprint, LevelChoice, LightVisibility, MapInfo,
    Rgb, ShadowLookup, Tolerance, Transmittance,
};
use dsm_io::{
    AnyCachedMap, BakeOptions, CachedMap, CachedShadow, Limits, PyramidOptions, TileCache,
};
use dsm_scene::{
    Image, ImageDifference, RenderSettings, Renderer, Scene, SceneRasterizer, SceneReference,
    TracedScene, open_scene,
};
use dsm_trace::LightFrame;
use mtsm::{LayeredKind, MultilayerSettings};
use serde::Serialize;
use shadow_maps::plain::{
    DepthMap, DepthMapSettings, PercentageCloserFilter, PercentageCloserShadow,
};

use super::bake::BakeJob;
use super::bake_layers::LayersJob;
use crate::args::{LayersRequest, Method, Render};
use crate::filtering;
use crate::interrupt::Interrupt;
use crate::layered::{self, AreaMethod, AreaShadow, AreaVisitor};
use crate::output::{picture, printable, progress};
use crate::parallel::with_threads;

/// Pixels of the map that is baked where none is given, their samples, and how
/// far it is off: it is thrown away, and may be large.
const RESOLUTION: u32 = 512;
const SAMPLES: u32 = 16;
const TOLERANCE: f32 = 0.01;

/// What `--json` prints.
#[derive(Serialize)]
struct Report<'a> {
    output: &'a Path,
    width: u32,
    height: u32,
    method: &'static str,
    /// Camera rays a pixel.
    samples: u32,
    factor: bool,
    bias: Option<BiasReport>,
    /// Seconds to open the scene and build its hierarchies.
    scene_s: f64,
    /// Seconds to make or open the map.
    map_s: f64,
    render_s: f64,
    compare: Option<Difference>,
}

/// The bias that was taken, in scene units.
#[derive(Serialize)]
struct BiasReport {
    rule: &'static str,
    least: f32,
    mean: f32,
    most: f32,
}

/// How far the picture is from another: of all its channels' values, less the
/// other's.
#[derive(Serialize)]
struct Difference {
    mean: f64,
    standard_deviation: f64,
    mean_absolute: f64,
    rmse: f64,
    max: f64,
}

impl From<ImageDifference> for Difference {
    fn from(found: ImageDifference) -> Self {
        let ImageDifference { mean, standard_deviation, mean_absolute, rmse, max } = found;
        Self { mean, standard_deviation, mean_absolute, rmse, max }
    }
}

pub(crate) fn run(request: &Render) -> Result<()> {
    with_threads(request.effort.threads, || {
        let started = Instant::now();
        let mut scene = open_scene(&request.scene)?;
        if let Some(size) = request.light_size {
            scene.light = scene.light.with_size(size.map(f64::from))?;
        }
        let traced = Arc::new(TracedScene::new(&scene)?);
        let job = RenderJob { request, scene: &scene, traced: &traced };
        let scene_s = started.elapsed().as_secs_f64();
        let Rendered { image, biases, map_s, render_s } = job.run()?;
        let compare = match &request.compare {
            Some(path) => {
                let other = picture::read_exr(path, image.size())?;
                image.difference(&other).map(Difference::from)
            }
            None => None,
        };
        picture::write_picture(&image, &request.output)?;
        let [width, height] = image.size();
        let report = Report {
            output: &request.output.path,
            width,
            height,
            method: request.method.name(),
            samples: request.samples,
            factor: request.factor,
            bias: biases.and_then(|(rule, biases)| BiasReport::new(rule, &biases)),
            scene_s,
            map_s,
            render_s,
            compare,
        };
        print(request, &report)
    })
}

impl BiasReport {
    fn new(bias: Bias, biases: &BiasSummary) -> Option<Self> {
        let mean = biases.mean()? as f32;
        let rule = match bias {
            Bias::Auto => "auto",
            _ => "fixed",
        };
        Some(Self { rule, least: biases.least as f32, mean, most: biases.most as f32 })
    }
}

fn print(request: &Render, report: &Report<'_>) -> Result<()> {
    let mut lines = String::new();
    if request.json {
        lines = format!("{}\n", serde_json::to_string(report)?);
    } else {
        if !request.quiet {
            lines += &format!(
                "{}: {} × {} pixels, {}, {} camera rays a pixel\n  \
                 scene {:.2} s, map {:.2} s, render {:.2} s\n",
                printable(&report.output.to_string_lossy()),
                report.width,
                report.height,
                report.method,
                report.samples,
                report.scene_s,
                report.map_s,
                report.render_s,
            );
            if let Some(BiasReport { rule, least, mean, most }) = report.bias {
                lines += &format!("  bias {rule}: {least:.3e} to {most:.3e}, mean {mean:.3e}\n");
            }
        }
        if let Some(Difference { mean, standard_deviation, mean_absolute, rmse, max }) =
            &report.compare
        {
            lines += &format!(
                "mean {mean:.6}, standard deviation {standard_deviation:.6}, \
                 mean absolute {mean_absolute:.6}, RMSE {rmse:.6}, max {max:.6}\n"
            );
        }
    }
    Ok(io::stdout().write_all(lines.as_bytes())?)
}

/// A picture, and what it took.
struct Rendered {
    image: Image,
    biases: Option<(Bias, BiasSummary)>,
    map_s: f64,
    render_s: f64,
}

/// A scene that is to be rendered.
struct RenderJob<'a> {
    request: &'a Render,
    scene: &'a Scene,
    traced: &'a Arc<TracedScene>,
}

impl RenderJob<'_> {
    fn run(&self) -> Result<Rendered> {
        match &self.request.method {
            Method::Filter { map, footprint, level, bias } => {
                self.filter(map.as_deref(), *footprint, *level, *bias)
            }
            Method::Area { map, how } => self.area(map.as_deref(), *how),
            &Method::Pcf { taps, width, bias } => self.pcf(taps, width, bias),
            &Method::Reference { rays } => {
                if self.scene.is_coloured() {
                    self.reference::<Rgb>(rays)
                } else {
                    self.reference::<f32>(rays)
                }
            }
        }
    }

    fn reference<T: Transmittance>(&self, rays: u32) -> Result<Rendered> {
        let shadow = SceneReference::<T>::new(Arc::clone(self.traced)).with_rays(rays);
        let (image, render_s) = self.render(&shadow, |never| match never {})?;
        Ok(Rendered { image, biases: None, map_s: 0.0, render_s })
    }

    fn pcf(&self, taps: u32, width: f32, bias: Bias) -> Result<Rendered> {
        let started = Instant::now();
        let raster = self.scene.light.raster([RESOLUTION; 2])?;
        let camera = raster.shadow_camera();
        let source = SceneRasterizer::<f32>::new(self.scene, raster)?;
        let mut settings = DepthMapSettings::new([RESOLUTION; 2], SAMPLES)?;
        settings.camera = Some(camera);
        let map = DepthMap::sample(&source, &settings)?;
        let info = MapInfo { camera: Some(camera), ..MapInfo::default() };
        let lookup = ShadowLookup::new(&info, [RESOLUTION; 2])?.with_bias(bias);
        let filter = PercentageCloserFilter::new(map.clone(), taps)?.with_width(width)?;
        let shadow = PercentageCloserShadow::new(filter, lookup);
        let map_s = started.elapsed().as_secs_f64();
        let (image, render_s) = self.render(&shadow, anyhow::Error::from)?;
        Ok(Rendered { image, biases: Some((bias, shadow.biases())), map_s, render_s })
    }

    fn area(&self, map: Option<&Path>, how: AreaMethod) -> Result<Rendered> {
        let started = Instant::now();
        // The folder goes when the picture is done.
        let (baked, folder);
        let path = match map {
            Some(path) => path,
            None => {
                folder = tempfile::tempdir().context("cannot make a folder for the map")?;
                baked = folder.path().join("map.dsm");
                self.bake_layers(&baked, how)?;
                &baked
            }
        };
        let Some(reader) = layered::open(path)? else {
            bail!("{}: a deep map has no layers: --method filter reads it", path.display());
        };
        layered::with_shadow(&reader, how, RenderArea { job: self, started })
    }

    /// Bakes the layers that the light's rays may meet: fragments, which come
    /// closest to rays through the scene, unless there is what they cannot hold
    /// or what does not go with them.
    fn bake_layers(&self, path: &Path, how: AreaMethod) -> Result<()> {
        let settings = MultilayerSettings::new([RESOLUTION; 2])?;
        let has_rule = matches!(how, AreaMethod::Trace { layers, .. } if layers.is_given());
        let kind = if has_rule || self.scene.has_media() {
            LayeredKind::Mtsm
        } else {
            LayeredKind::Fragments
        };
        let MultilayerSettings { max_layers, resets, .. } = settings;
        let layers = LayersRequest { kind, max_layers, resets, coverage: 8 };
        let name = self.request.scene.to_string_lossy();
        let job = self.bake_job(&name, settings.bake, None);
        LayersJob { job: &job, layers }.run(path).map(drop)
    }

    fn bake_job<'s>(
        &'s self,
        name: &'s str,
        settings: BakeSettings,
        pyramid: Option<PyramidOptions>,
    ) -> BakeJob<'s> {
        BakeJob {
            scene: self.scene,
            name,
            settings,
            coloured: None,
            options: BakeOptions::default().with_pyramid(pyramid),
            seed: self.request.seed,
            quiet: self.request.quiet,
        }
    }

    fn filter(
        &self,
        map: Option<&Path>,
        footprint: Footprint,
        level: LevelChoice,
        bias: Bias,
    ) -> Result<Rendered> {
        let started = Instant::now();
        let cache = TileCache::new(filtering::TILE_BYTES);
        // The folder goes when the picture is done.
        let (baked, folder);
        let path = match map {
            Some(path) => path,
            None => {
                folder = tempfile::tempdir().context("cannot make a folder for the map")?;
                baked = folder.path().join("map.dsm");
                self.bake(&baked, level)?;
                &baked
            }
        };
        let name = || format!("{}", path.display());
        let lookup = |lookup: ShadowLookup| {
            lookup.with_footprint(footprint).with_level(level).with_bias(bias)
        };
        match AnyCachedMap::open(&cache, path, &Limits::default())? {
            AnyCachedMap::Mono(map) => {
                let shadow = filtered(map, &footprint, level, lookup).with_context(name)?;
                self.filtered(&shadow, bias, started)
            }
            AnyCachedMap::Rgb(map) => {
                let shadow = filtered(map, &footprint, level, lookup).with_context(name)?;
                self.filtered(&shadow, bias, started)
            }
        }
    }

    fn filtered<T: Transmittance>(
        &self,
        shadow: &CachedShadow<T>,
        bias: Bias,
        started: Instant,
    ) -> Result<Rendered> {
        let map_s = started.elapsed().as_secs_f64();
        let (image, render_s) = self.render(shadow, anyhow::Error::from)?;
        Ok(Rendered { image, biases: Some((bias, shadow.biases())), map_s, render_s })
    }

    /// Bakes the light's map, with the levels that will be read.
    fn bake(&self, path: &Path, level: LevelChoice) -> Result<()> {
        let mut settings = BakeSettings::new([RESOLUTION; 2])?;
        settings.sampling = dsm_core::PixelSampling::new(SAMPLES, self.request.seed)?;
        settings.tolerance = Some(Tolerance::new(TOLERANCE)?);
        let pyramid = (level != LevelChoice::FINEST).then(PyramidOptions::default);
        let name = self.request.scene.to_string_lossy();
        self.bake_job(&name, settings, pyramid).run(path).map(|_| ())
    }

    /// Renders with these shadows; how long that took.
    fn render<V: LightVisibility>(
        &self,
        shadow: &V,
        failed: impl Fn(V::Error) -> anyhow::Error,
    ) -> Result<(Image, f64)>
    where
        V::Error: Send,
    {
        let request = self.request;
        let camera = self.scene.camera;
        let camera = camera.raster(request.resolution.unwrap_or(camera.resolution))?;
        let mut settings = RenderSettings::new(request.samples, request.seed)?;
        settings.factor = request.factor;
        let renderer =
            Renderer::new(Arc::clone(self.traced), camera, self.scene.light.area()?, settings);
        render_with_bar(&renderer, shadow, failed, request.quiet)
    }
}

/// Renders a scene with the soft shadows of a layered map.
struct RenderArea<'a, 'b> {
    job: &'a RenderJob<'b>,
    started: Instant,
}

impl AreaVisitor for RenderArea<'_, '_> {
    type Output = Rendered;

    fn light(&self, _: &LightFrame) -> Result<AreaLight> {
        Ok(self.job.scene.light.area()?)
    }

    fn visit<V: AreaShadow>(self, shadow: &V) -> Result<Rendered> {
        let map_s = self.started.elapsed().as_secs_f64();
        let (image, render_s) = self.job.render(shadow, |never| match never {})?;
        Ok(Rendered { image, biases: None, map_s, render_s })
    }
}

/// Renders on the current pool, with a progress bar, until somebody interrupts
/// it; how long that took.
pub(crate) fn render_with_bar<V: LightVisibility>(
    renderer: &Renderer,
    shadow: &V,
    failed: impl Fn(V::Error) -> anyhow::Error,
    quiet: bool,
) -> Result<(Image, f64)>
where
    V::Error: Send,
{
    let started = Instant::now();
    let interrupt = Interrupt::listen()?;
    let bar = progress::bar(0, "rendering".to_owned(), quiet);
    let watch = |progress: dsm_scene::RenderProgress| {
        bar.set_length(progress.blocks);
        bar.set_position(progress.done);
        if interrupt.is_asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let image = renderer.render(shadow, watch).map_err(failed);
    bar.finish_and_clear();
    match image? {
        Some(image) => Ok((image, started.elapsed().as_secs_f64())),
        None => bail!("rendering: interrupted"),
    }
}

/// The shadows of a map's file.
fn filtered<T: Transmittance>(
    map: CachedMap<T>,
    footprint: &Footprint,
    level: LevelChoice,
    set: impl Fn(ShadowLookup) -> ShadowLookup,
) -> Result<CachedShadow<T>> {
    let lookup = set(filtering::shadow_lookup(&map)?);
    Ok(CachedShadow::of_cursors(filtering::cursors(map, footprint, level)?, lookup))
}
