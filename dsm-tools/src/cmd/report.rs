//! `report`: a scene's shadows by every method, on a page.

use std::ffi::OsString;
use std::io::{self, Write};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, Result};
use deepshadow::files::detail::{TileRect, replace_file};
use deepshadow::scene::detail::{SceneOptions, open_scene_with};
use deepshadow::scene::{Scene, TracedScene};
use deepshadow::{Kind, ShadowMap};

use super::inspect::slice_of;
use super::render::{RenderJob, Rendered};
use crate::args::{self, Method, Render};
use crate::input::STREAM;
use crate::memory;
use crate::output::summary::Summary;
use crate::output::warnings::Warnings;
use crate::output::{limit, printable};
use crate::parallel::with_threads;
use crate::report::{Cost, MapEntry, Picture, Report};

/// The largest side of a picture of a map.
const LARGEST_SLICE: u32 = 512;

pub(crate) fn run(request: &args::Report) -> Result<()> {
    let report = with_threads(request.effort.threads, || make(request))?;
    let page = report.html()?;
    if request.html.as_os_str() == STREAM {
        return Ok(io::stdout().write_all(page.as_bytes())?);
    }
    replace_file(&request.html, page.as_bytes())?;
    if request.quiet {
        return Ok(());
    }
    let name = printable(&request.html.to_string_lossy());
    let [maps, pictures] = [report.maps.len(), report.pictures.len()];
    let line = format!("{name}: {maps} maps, {pictures} pictures, {} bytes\n", page.len());
    Ok(io::stdout().write_all(line.as_bytes())?)
}

fn make(request: &args::Report) -> Result<Report> {
    let names = request.scene.iter().chain(&request.maps).map(|path| path.to_string_lossy());
    let mut report = Report {
        title: format!("Shadows of {}", names.collect::<Vec<_>>().join(", ")),
        about: Vec::new(),
        maps: Vec::new(),
        reference: None,
        pictures: Vec::new(),
        left_out: Vec::new(),
        times: request.times,
    };
    for path in &request.maps {
        report.maps.push(entry(path, name_of(path))?);
    }
    if let Some(path) = &request.scene {
        let scene = open_scene_with(path, &SceneOptions::default().memory(memory::for_a_scene()))?;
        let work = Work { request, path, traced: Arc::new(TracedScene::new(&scene)?), scene };
        work.render_all(&mut report)?;
    }
    Ok(report)
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// What a report says of a map.
fn entry(path: &Path, name: String) -> Result<MapEntry> {
    let map = ShadowMap::open(path)?;
    let [width, height] = map.size();
    let is_small = width.max(height) <= LARGEST_SLICE;
    let first = TileRect { x: 0, y: 0, width: 1, height: 1 };
    let has_functions = map.functions(0, first)?.is_some();
    // Behind everything.
    let slice = match is_small && has_functions {
        true => slice_of(&map, f32::INFINITY, |slice| slice.image())?,
        false => None,
    };
    Ok(MapEntry {
        name,
        summary: serde_json::to_value(Summary::new(&map)?)?,
        bytes: path.metadata().with_context(|| path.display().to_string())?.len(),
        notes: limit::of_map(&map)?.into_iter().collect(),
        slice,
    })
}

/// A scene of which pictures are made.
struct Work<'a> {
    request: &'a args::Report,
    path: &'a Path,
    scene: Scene,
    traced: Arc<TracedScene>,
}

impl Work<'_> {
    fn render_all(&self, report: &mut Report) -> Result<()> {
        let args::Report { rays, samples, resolution, shaded, seed, .. } = *self.request;
        let [width, height] = resolution;
        report.about.push(format!(
            "{}, {width} × {height} pixels, {samples} camera rays a pixel, seed {seed}. The \
             reference takes {} rays through the scene from every point, other methods that trace \
             {rays}.",
            if shaded { "Shaded pictures" } else { "Shadow factors" },
            rays.saturating_mul(4)
        ));
        report
            .about
            .extend(self.scene.warnings().iter().map(|warning| format!("Warning: {warning}")));
        let mut reference =
            self.picture("reference", None, &[("--rays", rays.saturating_mul(4))])?;
        reference.method = "reference".to_owned();
        report.reference = Some(reference);
        let folder = tempfile::tempdir().context("cannot make a folder for maps")?;
        for method in ["filter", "trace", "prefilter", "hybrid", "attenuation", "pcf", "coherence"]
        {
            let rays = if ["trace", "hybrid", "pcf", "coherence"].contains(&method) {
                &[("--rays", rays)][..]
            } else {
                &[]
            };
            if let Err(error) = self.add(method, rays, folder.path(), report) {
                report.left_out.push((method.to_owned(), format!("{error:#}")));
            }
        }
        Ok(())
    }

    /// Adds the pictures by a method: one a map that was given and that it reads, else one with a map
    /// that is baked for it.
    fn add(
        &self,
        method: &str,
        rays: &[(&str, u32)],
        folder: &Path,
        report: &mut Report,
    ) -> Result<()> {
        let request = self.request_of(method, None, rays)?;
        let Method::Map { method: of_map, .. } = &request.method else {
            report.pictures.push(self.picture(method, None, rays)?);
            return Ok(());
        };
        let mut given = false;
        for path in &self.request.maps {
            let Some(kind) = Kind::named(ShadowMap::open(path)?.kind()) else { continue };
            if reads(method, kind) {
                given = true;
                let mut picture = self.picture(method, Some(path), rays)?;
                picture.map = Some(name_of(path));
                report.pictures.push(picture);
            }
        }
        if given {
            return Ok(());
        }
        let name = match method {
            "filter" => "baked, deep",
            "prefilter" | "hybrid" => "baked, prefiltered",
            "attenuation" => "baked, attenuation",
            _ => "baked, fragments",
        };
        let path = folder.join(format!("{}.dsm", name.replace([',', ' '], "")));
        let mut bake_s = None;
        if !path.exists() {
            let started = Instant::now();
            let mut warnings = Warnings::new(true);
            self.job(&request).bake_into(*of_map, &path, &mut warnings)?;
            bake_s = Some(started.elapsed().as_secs_f64());
            report.maps.push(entry(&path, name.to_owned())?);
        }
        let mut picture = self.picture(method, Some(&path), rays)?;
        picture.map = Some(name.to_owned());
        picture.cost.bake_s = bake_s;
        report.pictures.push(picture);
        Ok(())
    }

    fn job<'a>(&'a self, request: &'a Render) -> RenderJob<'a> {
        RenderJob { request, scene: &self.scene, traced: &self.traced }
    }

    /// The request that `render` would have for a picture.
    fn request_of(
        &self,
        method: &str,
        map: Option<&Path>,
        numbers: &[(&str, u32)],
    ) -> Result<Box<Render>> {
        let args::Report { samples, resolution: [width, height], seed, .. } = *self.request;
        let mut words: Vec<OsString> = vec![self.path.into()];
        let mut add = |name: &str, value: OsString| words.extend([name.into(), value]);
        add("--output", "none.png".into());
        add("--method", method.into());
        add("--samples", samples.to_string().into());
        add("--seed", seed.to_string().into());
        add("--resolution", format!("{width}x{height}").into());
        for (name, number) in numbers {
            add(name, number.to_string().into());
        }
        if let Some(map) = map {
            add("--map", map.into());
        }
        if !self.request.shaded {
            words.push("--factor".into());
        }
        if self.request.quiet {
            words.push("--quiet".into());
        }
        Ok(args::render_request(&words)?)
    }

    fn picture(
        &self,
        method: &str,
        map: Option<&Path>,
        numbers: &[(&str, u32)],
    ) -> Result<Picture> {
        let request = self.request_of(method, map, numbers)?;
        memory::forget_peak();
        // What a warning says stands with the picture.
        let mut warnings = Warnings::new(true);
        let rendered = self.job(&request).run(&mut warnings)?;
        let Rendered { image, mut notes, map_s, render_s, .. } = rendered;
        notes.extend(warnings.lines().iter().cloned());
        Ok(Picture {
            method: method.to_owned(),
            map: None,
            image,
            notes,
            cost: Cost { bake_s: None, open_s: map_s, render_s, peak: memory::peak() },
        })
    }
}

/// Whether a method makes pictures of maps of a kind.
fn reads(method: &str, kind: Kind) -> bool {
    match method {
        "filter" => [Kind::DEEP, Kind::MTSM, Kind::LAYERS].contains(&kind),
        "trace" => [Kind::FRAGMENTS, Kind::MTSM, Kind::LAYERS, Kind::VIEWS].contains(&kind),
        "prefilter" | "hybrid" => kind == Kind::PREFILTERED,
        "attenuation" => kind == Kind::ATTENUATION,
        _ => false,
    }
}
