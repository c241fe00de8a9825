//! `demo`: all the way from a scene to pictures.

use std::fs;
use std::io::{self, Write};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, Result};
use deepshadow::files::detail::check_output;
use deepshadow::files::{Limits, MapReader, PyramidOptions, mip};
use deepshadow::scene::detail::{Image, RenderSettings, Renderer};
use deepshadow::scene::{Scene, TracedScene, builtin_scene};
use deepshadow::visibility::{Bias, DeepMap, Filter, FilterShape, Footprint};
use deepshadow::{Bake, FilterMethod, Query, ShadowMap};

use super::bake::bake_scene;
use super::inspect::{plot_pixel, write_slice};
use super::render::render_with_bar;
use crate::args::{Demo, ImageFile, ImageFormat, SliceFile};
use crate::output::progress::Watch;
use crate::output::{picture, printable};
use crate::parallel::with_threads;

/// Width and height of the map.
const RESOLUTION: u32 = 512;
/// Width and height of a rendered picture, and camera rays a pixel.
const PICTURE: [u32; 2] = [400, 300];
const CAMERA_RAYS: u32 = 9;

pub(crate) fn run(request: &Demo) -> Result<()> {
    with_threads(None, || Demonstration { request, step: Instant::now() }.run())
}

/// The steps, and when the current one began.
struct Demonstration<'a> {
    request: &'a Demo,
    step: Instant,
}

impl Demonstration<'_> {
    fn run(mut self) -> Result<()> {
        let folder = &self.request.folder;
        fs::create_dir_all(folder)
            .with_context(|| format!("cannot make the folder {}", folder.display()))?;
        let path = |name: &str| folder.join(name);
        for name in ["hairball.dsm", "pixel.png", "shadow.png", "render.png"] {
            check_output(&path(name))?;
        }
        let quiet = self.request.quiet;

        let scene = builtin_scene("hairball")?;
        self.say("scene", "50,000 curly hairs on a ball over a floor")?;

        let map_path = path("hairball.dsm");
        let settings = Bake::new([RESOLUTION; 2])?;
        let report = bake_scene(&scene, "builtin:hairball", settings, &map_path, quiet)?;
        let map = MapReader::open(&map_path, &Limits::default())?;
        let level = map.levels()[0];
        let vertices = map.directory(0)?.iter().map(|(_, entry)| entry.vertex_count).sum::<u64>();
        let pixels = level.pixel_count() as f64;
        self.say(
            "bake",
            &format!(
                "{RESOLUTION} × {RESOLUTION} pixels, {} samples with {} hits into {:.1} vertices a \
                 pixel, off by {:.4} at most",
                report.samples,
                report.hits,
                vertices as f64 / pixels,
                level.error.max
            ),
        )?;

        let watch = Watch::start("averaging", quiet)?;
        mip(&map, &map_path, &PyramidOptions::default(), |progress| watch.at(progress))?;
        drop(watch);
        drop(map);
        let map = MapReader::open(&map_path, &Limits::default())?;
        let bytes = map.container().file_length();
        self.say("mip", &format!("{} levels, {bytes} bytes", map.levels().len()))?;

        if let Some(error) = map.verify().into_iter().next() {
            return Err(error).context("verifying");
        }
        self.say("verify", "every checksum and every function is as it must be")?;

        let deep = map.read_map::<f32>(0)?;
        let [x, y] = busiest_pixel(&deep);
        let file = ImageFile { path: path("pixel.png"), format: ImageFormat::Png };
        plot_pixel(deep.pixel(x, y), &format!("hairball.dsm, pixel ({x}, {y})"), &file)?;
        let what = format!("{}: the light along pixel ({x}, {y})", file.path.display());
        self.say("plot", &what)?;

        let view = scene.light.view;
        let depth = (view.target - view.eye).length() as f32;
        let image = ImageFile { path: path("shadow.png"), format: ImageFormat::Png };
        let what = format!("{}: the light left at depth {depth}", image.path.display());
        write_slice(&ShadowMap::open(&map_path)?, &SliceFile { depth, image })?;
        self.say("slice", &what)?;
        drop((deep, map));

        let image = ImageFile { path: path("render.png"), format: ImageFormat::Png };
        picture::write_picture(&self.render(&scene, &map_path)?, &image)?;
        let what = "the hair without and with the shadow it casts on itself";
        self.say("render", &format!("{}: {what}", image.path.display()))
    }

    /// The scene without self-shadowing beside the same with it.
    fn render(&self, scene: &Scene, map: &Path) -> Result<Image> {
        let filter = Filter::new(FilterShape::Tent, 2.0)?;
        let footprint = Footprint::Isotropic(filter);
        let method = FilterMethod { footprint, bias: Bias::Auto, ..FilterMethod::POINT };
        let light = scene.light.area()?;
        let query = Query::new().with_method(method).with_light(light);
        let shadow = ShadowMap::open(map)?.shadow(&query)?;
        let traced = Arc::new(TracedScene::new(scene)?);
        let mut settings = RenderSettings::new(CAMERA_RAYS, 0)?;
        let mut draw = |self_shadowing| {
            settings.self_shadowing = self_shadowing;
            let camera = scene.camera.raster(PICTURE)?;
            let renderer = Renderer::new(Arc::clone(&traced), camera, light, settings.clone());
            render_with_bar(&renderer, &shadow, self.request.quiet).map(|(image, _)| image)
        };
        let images = [draw(false)?, draw(true)?];
        Image::beside(&images).context("both are as high")
    }

    /// Ends a step: how long it took and what came of it.
    fn say(&mut self, name: &str, what: &str) -> Result<()> {
        let seconds = self.step.elapsed().as_secs_f64();
        self.step = Instant::now();
        if self.request.quiet {
            return Ok(());
        }
        let line = format!("{name:<7}{seconds:>6.2} s  {}\n", printable(what));
        Ok(io::stdout().write_all(line.as_bytes())?)
    }
}

/// The pixel with the most vertices; of several the first.
fn busiest_pixel(map: &DeepMap<f32>) -> [u32; 2] {
    let view = map.pixels().view();
    let pixels = (0..view.height()).flat_map(|y| (0..view.width()).map(move |x| [x, y]));
    pixels.rev().max_by_key(|&[x, y]| view.pixel(x, y).len()).unwrap_or_default()
}
