//! `render`: a scene under its light.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use deepshadow::detail::{PlainShadow, plain_shadow};
use deepshadow::scene::detail::{
    Image, ImageDifference, RenderSettings, Renderer, open_scene_with,
};
use deepshadow::scene::{Scene, TracedScene};
use deepshadow::visibility::detail::BiasSummary;
use deepshadow::visibility::{Bias, LevelChoice, LightVisibility, Tolerance};
use deepshadow::{Error, Kind, Method as MapMethod, Query, Shadow, ShadowMap};
use serde::Serialize;
use tempfile::TempDir;

use super::bake::{bake_scene, doubts};
use crate::args::{Method, Render};
use crate::in_map::{InMap, Watched, empty_is, is_empty, is_part};
use crate::output::progress::Watch;
use crate::output::warnings::Warnings;
use crate::output::{limit, picture, printable};
use crate::parallel::with_threads;
use crate::wide_light::{self, RESOLUTION};

/// Samples a pixel of the map that is baked where none is given, and how far it is off:
/// it is thrown away, and may be large.
const SAMPLES: u32 = 16;
const TOLERANCE: f32 = 0.01;

/// The JSON document.
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
    /// What the bound of the map's layers changed.
    notes: Vec<String>,
    /// What the scene's files hold that was not understood, and what may not be meant.
    warnings: &'a Warnings,
}

/// The bias that was taken, in scene units.
#[derive(Serialize)]
struct BiasReport {
    rule: &'static str,
    min: f32,
    mean: f32,
    max: f32,
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
        let mut scene = open_scene_with(&request.scene, &request.scene_options)?;
        let mut warnings = Warnings::new(request.strict);
        warnings.extend(scene.warnings());
        if let Some(size) = request.light_size {
            scene.light = scene.light.with_size(size.map(f64::from))?;
        }
        let traced = Arc::new(TracedScene::new(&scene)?);
        let job = RenderJob { request, scene: &scene, traced: &traced };
        let scene_s = started.elapsed().as_secs_f64();
        let Rendered { image, biases, notes, map_s, render_s } = job.run(&mut warnings)?;
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
            notes,
            warnings: &warnings,
        };
        print(request, &report)?;
        warnings.finish()
    })
}

impl BiasReport {
    fn new(bias: Bias, biases: &BiasSummary) -> Option<Self> {
        let mean = biases.mean()? as f32;
        let rule = match bias {
            Bias::Auto => "auto",
            _ => "fixed",
        };
        Some(Self { rule, min: biases.min as f32, mean, max: biases.max as f32 })
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
            if let Some(BiasReport { rule, min, mean, max }) = report.bias {
                lines += &format!("  bias {rule}: {min:.3e} to {max:.3e}, mean {mean:.3e}\n");
            }
            lines.extend(report.notes.iter().map(|note| format!("  {note}\n")));
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
pub(crate) struct Rendered {
    pub(crate) image: Image,
    biases: Option<(Bias, BiasSummary)>,
    pub(crate) notes: Vec<String>,
    pub(crate) map_s: f64,
    pub(crate) render_s: f64,
}

/// A scene that is to be rendered.
pub(crate) struct RenderJob<'a> {
    pub(crate) request: &'a Render,
    pub(crate) scene: &'a Scene,
    pub(crate) traced: &'a Arc<TracedScene>,
}

impl RenderJob<'_> {
    pub(crate) fn run(&self, warnings: &mut Warnings) -> Result<Rendered> {
        let started = Instant::now();
        // The folder goes when the picture is done.
        let (mut folder, mut bias, mut notes) = (None, None, Vec::new());
        // Of a map that was given: one that is baked shows what its light sees.
        let mut seen = InMap::new(None);
        let shadow = match &self.request.method {
            Method::Map { map, method } => {
                if let MapMethod::Filter(filter) = method {
                    bias = Some(filter.bias);
                }
                let query = Query::new().with_method(*method);
                let query = query.with_light(self.scene.light.area()?);
                let map = match map {
                    Some(path) => {
                        let map = ShadowMap::open(path)?;
                        let view = map.view()?;
                        warnings.extend(self.unlike(&map, path)?);
                        warnings.extend(map.container().remark());
                        seen = InMap::new(view);
                        map
                    }
                    None => ShadowMap::open(self.bake_for(*method, &mut folder, warnings)?)?,
                };
                if let MapMethod::Filter(_) = method {
                    warnings.extend(wide_light::of_scene(self.scene, method.name()));
                }
                notes.extend(limit::of_map(&map)?);
                match method {
                    MapMethod::Hybrid(_) => map.hybrid_shadow(Arc::clone(self.traced), &query)?,
                    _ => map.shadow(&query)?,
                }
            }
            &Method::Plain { taps, width, bias: given } => {
                bias = Some(given);
                warnings.extend(wide_light::of_scene(self.scene, "pcf"));
                let settings = PlainShadow::new(taps).with_width(width).with_bias(given);
                plain_shadow(self.scene, &self.scene.light, &settings)?
            }
            &Method::Reference { rays } => {
                Shadow::reference(Arc::clone(self.traced), self.scene, rays)?
            }
            Method::Coherent(method) => {
                Shadow::coherent(Arc::clone(self.traced), self.scene, method)?
            }
        };
        let map_s = started.elapsed().as_secs_f64();
        let (image, render_s) = self.render(&Watched { shadow: &shadow, seen: &seen })?;
        warnings.extend(seen.warning());
        if !seen.is_asked() {
            warnings.add("the picture shows nothing that light could reach");
        }
        if let Some(counted) = shadow.statistics().coherence.filter(|all| all.receivers > 0) {
            let a_point = |count: u64| count as f64 / counted.receivers as f64;
            let (rays, cells) = (a_point(counted.rays), a_point(counted.cells));
            notes.push(format!("{rays:.1} of {cells:.0} rays a point traced"));
        }
        let biases = bias.and_then(|bias| Some((bias, shadow.statistics().biases?)));
        Ok(Rendered { image, biases, notes, map_s, render_s })
    }

    /// What a map that was given is not of the scene.
    fn unlike(&self, map: &ShadowMap, path: &Path) -> Result<Vec<String>> {
        let (mut found, name) = (Vec::new(), path.display());
        if map.view()?.is_some_and(|view| !view.is_of(&self.scene.light)) {
            found.push(format!("{name} is no map of the scene's light: it is seen from elsewhere"));
        }
        if is_empty(map)? && !is_part(map) {
            found.push(format!("{name} holds nothing: it is {}", empty_is(map.kind())));
        }
        Ok(found)
    }

    /// Bakes the map that a method reads into a folder of its own.
    fn bake_for(
        &self,
        method: MapMethod,
        folder: &mut Option<TempDir>,
        warnings: &mut Warnings,
    ) -> Result<PathBuf> {
        let made = tempfile::tempdir().context("cannot make a folder for the map")?;
        let map = folder.insert(made).path().join("map.dsm");
        self.bake_into(method, &map, warnings)?;
        Ok(map)
    }

    /// Bakes the map that a method reads into a file.
    pub(crate) fn bake_into(
        &self,
        method: MapMethod,
        map: &Path,
        warnings: &mut Warnings,
    ) -> Result<()> {
        let name = self.request.scene.to_string_lossy();
        let settings = self.settings(method)?;
        let report = bake_scene(self.scene, &name, settings.clone(), map, self.request.quiet)?;
        warnings.extend(doubts(self.scene, &settings, &report));
        Ok(())
    }

    /// The settings of a map that is baked for a picture alone.
    fn settings(&self, method: MapMethod) -> Result<deepshadow::Bake> {
        let settings = deepshadow::Bake::new([RESOLUTION; 2])?.with_seed(self.request.seed);
        let MapMethod::Filter(filter) = method else {
            let kind = Kind::for_area_lights(&method);
            if matches!(method, MapMethod::Trace(trace) if trace.far_table.is_some())
                && !kind.has_planes()
            {
                bail!(
                    "--far-table is for maps of kind fragments; this picture needs kind {}",
                    kind.name()
                );
            }
            let found = deepshadow::Bake::new(kind.resolution_for(self.scene))?;
            return Ok(found.with_kind(kind).with_seed(self.request.seed));
        };
        let settings = settings.with_samples(SAMPLES).with_tolerance(Tolerance::new(TOLERANCE)?);
        Ok(if filter.level == LevelChoice::FINEST {
            settings
        } else {
            settings.with_pyramid(deepshadow::files::PyramidOptions::default())
        })
    }

    /// Renders with these shadows; how long that took.
    fn render(&self, shadow: &Watched<'_>) -> Result<(Image, f64)> {
        let request = self.request;
        let camera = self.scene.camera;
        let camera = camera.raster(request.resolution.unwrap_or(camera.resolution))?;
        let mut settings = RenderSettings::new(request.samples, request.seed)?;
        settings.factor = request.factor;
        let light = self.scene.light.area()?;
        let renderer = Renderer::new(Arc::clone(self.traced), camera, light, settings);
        render_with_bar(&renderer, shadow, request.quiet)
    }
}

/// Renders on the current pool, with a progress bar, until somebody interrupts
/// it; how long that took.
pub(crate) fn render_with_bar<S: LightVisibility<Error = Error>>(
    renderer: &Renderer,
    shadow: &S,
    quiet: bool,
) -> Result<(Image, f64)> {
    let started = Instant::now();
    let watch = Watch::start("rendering", quiet)?;
    let image = renderer.render(shadow, |progress| watch.at(progress));
    drop(watch);
    match image? {
        Some(image) => Ok((image, started.elapsed().as_secs_f64())),
        None => bail!("rendering: interrupted"),
    }
}
