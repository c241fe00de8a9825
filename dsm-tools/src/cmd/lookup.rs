//! `lookup`: the light that reaches points.

use std::fs::File;
use std::io::{self, BufWriter, IsTerminal, Read, Write};
use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use dsm_core::{
    AreaLight, Bias, Facing, Footprint, LevelChoice, LightExtent, Pyramid, Receiver, Rgb,
    ShadedPoint, ShadowLookup, Transmittance, VisibilityField,
};
use dsm_io::{AnyCachedMap, CachedMap, CursorPool, Limits, TileCache};
use dsm_trace::{LightFrame, TraceStatistics};
use glam::DVec3;
use indicatif::ProgressBar;
use mtsm::LayeredReader;
use rayon::prelude::*;
use serde::Serialize;

use crate::args::{Lookup, MethodName, Space};
use crate::filtering;
use crate::layered::{self, AreaMethod, AreaShadow, AreaVisitor};
use crate::output::{light, progress};
use crate::parallel::with_threads;
use crate::points::PointReader;

/// Points that are in memory at a time.
const CHUNK: usize = 1 << 16;
/// Points that one task takes.
const TASK: usize = 1 << 10;

/// What `--stats` prints.
#[derive(Serialize)]
struct Statistics {
    points: u64,
    /// Rays that were traced: a filter needs none.
    rays: u64,
    /// Seconds to open the map.
    open_s: f64,
    /// Seconds to project the points, read tiles and filter them.
    lookup_s: f64,
    /// Rays that left the map at its depths.
    #[serde(skip_serializing_if = "Option::is_none")]
    leaving: Option<u64>,
    /// Rays of points that lie no deeper than the light.
    #[serde(skip_serializing_if = "Option::is_none")]
    beside: Option<u64>,
    /// Whether a far table was used.
    #[serde(skip_serializing_if = "Option::is_none")]
    far_table: Option<bool>,
}

/// What a method of area lights has to say for itself.
#[derive(Clone, Copy, Default)]
struct Traced {
    statistics: Option<TraceStatistics>,
    far_table: Option<bool>,
}

pub(crate) fn run(request: &Lookup) -> Result<()> {
    with_threads(request.effort.threads, || {
        let start = Instant::now();
        if let Some(reader) = layered::open(&request.map)? {
            return run_layered(&reader, request, start);
        }
        if let Some(MethodName::Trace | MethodName::Pcf) = request.method {
            bail!(
                "{}: a deep map has no layers to trace or to filter over a light's outline",
                request.map.display()
            );
        }
        if request.rays.is_some() || request.light_size.is_some() {
            bail!("{}: --rays and --light-size are for layered maps", request.map.display());
        }
        if request.layers.is_given() {
            bail!("{}: --rule and --z-threshold are for layered maps", request.map.display());
        }
        let cache = TileCache::new(filtering::TILE_BYTES);
        let map = AnyCachedMap::open(&cache, &request.map, &Limits::default())?;
        let open_s = start.elapsed().as_secs_f64();
        let (points, time) = match map {
            AnyCachedMap::Mono(map) => answer_cached(map, request),
            AnyCachedMap::Rgb(map) => answer_cached(map, request),
        }?;
        print_statistics(request, points, time, open_s, Traced::default())
    })
}

fn print_statistics(
    request: &Lookup,
    points: u64,
    time: Duration,
    open_s: f64,
    traced: Traced,
) -> Result<()> {
    if request.stats {
        let Traced { statistics: traced, far_table } = traced;
        let statistics = Statistics {
            points,
            rays: traced.map_or(0, |traced| traced.rays),
            open_s,
            lookup_s: time.as_secs_f64(),
            leaving: traced.map(|traced| traced.leaving),
            beside: traced.map(|traced| traced.beside),
            far_table,
        };
        writeln!(io::stderr(), "{}", serde_json::to_string(&statistics)?)?;
    }
    Ok(())
}

fn run_layered(reader: &LayeredReader, request: &Lookup, start: Instant) -> Result<()> {
    let rays = request.rays.unwrap_or(256);
    let bias = request.bias.map(f64::from);
    let method = match request.method {
        Some(MethodName::Filter) if reader.metadata().channels == 1 => {
            return filter_runs::<f32>(reader, request, start);
        }
        Some(MethodName::Filter) => return filter_runs::<Rgb>(reader, request, start),
        Some(MethodName::Pcf) => AreaMethod::Pcf { taps: rays, bias: Some(bias.unwrap_or(0.0)) },
        _ if bias.is_some_and(|bias| bias < 0.0) => {
            bail!("--bias: a ray does not start before its point");
        }
        _ => AreaMethod::Trace { rays, start: bias, layers: request.layers },
    };
    if request.layers.is_given() && !matches!(method, AreaMethod::Trace { .. }) {
        bail!("{}: --rule and --z-threshold are for --method trace", request.map.display());
    }
    if request.footprint != Footprint::Point || request.level != LevelChoice::FINEST {
        bail!("{}: --filter and --level are for --method filter", request.map.display());
    }
    let light = layered::light_extent(reader, request.light_size)?;
    layered::with_shadow(reader, method, AnswerArea { request, light, start })
}

/// Answers points by the first runs of a layered map.
fn filter_runs<T: Transmittance>(
    reader: &LayeredReader,
    request: &Lookup,
    start: Instant,
) -> Result<()> {
    let info = reader.metadata().info;
    let map = reader.multilayer_map::<T>()?.deep_map()?;
    let pyramid = Pyramid::new(vec![map])?;
    filtering::check(&pyramid, &request.footprint, request.level)?;
    let size = [reader.metadata().width, reader.metadata().height];
    let world = match request.space {
        Space::World => Some(set(ShadowLookup::new(&info, size)?, request)),
        Space::Raster => None,
    };
    let open_s = start.elapsed().as_secs_f64();
    let (points, time) = answer_all(request, |_, points| {
        lights(&pyramid, &world, request, points).map_err(|never| match never {})
    })?;
    print_statistics(request, points, time, open_s, Traced::default())
}

/// Answers points by the soft shadows of a layered map.
struct AnswerArea<'a> {
    request: &'a Lookup,
    light: LightExtent,
    start: Instant,
}

impl AreaVisitor for AnswerArea<'_> {
    type Output = ();

    fn light(&self, frame: &LightFrame) -> Result<AreaLight> {
        Ok(frame.area_light(self.light))
    }

    fn visit<V: AreaShadow>(self, shadow: &V) -> Result<()> {
        let light = self.light(shadow.frame())?;
        let Self { request, start, .. } = self;
        let seed = request.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let open_s = start.elapsed().as_secs_f64();
        let (points, time) = answer_all(request, |first, points| {
            let shaded = |(number, point): (u64, &[f64; 3])| {
                let [x, y, z] = *point;
                let position = match request.space {
                    Space::World => DVec3::new(x, y, z),
                    Space::Raster => shadow.frame().unproject(x, y, z),
                };
                ShadedPoint { position, facing: Facing::Light, seed: seed.wrapping_add(number) }
            };
            let points: Vec<_> = (first..).zip(points).map(shaded).collect();
            let mut lights = Vec::with_capacity(points.len());
            let done = shadow.visibilities(&points, &light, &mut lights);
            done.map(|()| lights).map_err(|never| match never {})
        })?;
        let traced =
            Traced { statistics: Some(shadow.statistics()), far_table: shadow.has_far_table() };
        print_statistics(request, points, time, open_s, traced)
    }
}

/// Answers points by filtered lookups in a deep map's file.
fn answer_cached<T: Transmittance>(map: CachedMap<T>, request: &Lookup) -> Result<(u64, Duration)> {
    let shadow = Shadow::new(map, request).with_context(|| format!("{}", request.map.display()))?;
    answer_all(request, |_, points| shadow.lights(points))
}

/// Answers every point of the file, on stdout, by asking `lights` for some at a
/// time, with the number of the first. Returns how many there were, and how long
/// their lookups took.
fn answer_all<T: Transmittance>(
    request: &Lookup,
    lights: impl Fn(u64, &[[f64; 3]]) -> Result<Vec<T>> + Sync,
) -> Result<(u64, Duration)> {
    let path = request.points.as_path();
    let (mut points, bar) = open(path, request.quiet)?;
    let mut output = BufWriter::new(io::stdout().lock());
    output.write_all(light::header::<T>())?;
    let (mut count, mut time) = (0_u64, Duration::ZERO);
    let mut chunk = Vec::new();
    loop {
        points.read(&mut chunk, CHUNK).with_context(|| format!("{}", path.display()))?;
        if chunk.is_empty() {
            break;
        }
        let start = Instant::now();
        let tasks = chunk.par_chunks(TASK).enumerate();
        let values: Vec<Vec<T>> = tasks
            .map(|(task, points)| lights(count + (task * TASK) as u64, points))
            .collect::<Result<_>>()?;
        time += start.elapsed();
        let lines: Vec<Vec<u8>> = values
            .par_iter()
            .map(|values| {
                let mut lines = Vec::with_capacity(values.len() * 12);
                values.iter().for_each(|&value| light::append_line(value, &mut lines));
                lines
            })
            .collect();
        for lines in lines {
            output.write_all(&lines)?;
        }
        count += chunk.len() as u64;
    }
    bar.finish_and_clear();
    output.flush()?;
    Ok((count, time))
}

/// Opens the points. The bar shows how many of their bytes are read, unless the
/// answers fill the terminal.
fn open(path: &Path, quiet: bool) -> Result<(PointReader<impl Read>, ProgressBar)> {
    let file = File::open(path).with_context(|| format!("cannot open {}", path.display()))?;
    let bytes = file.metadata().map_or(0, |metadata| metadata.len());
    let quiet = quiet || io::stdout().is_terminal();
    let bar = progress::bar(bytes, "looking up".to_owned(), quiet);
    let points = PointReader::new(bar.wrap_read(file));
    Ok((points.with_context(|| format!("{}", path.display()))?, bar))
}

/// How points of the world are asked.
fn set(lookup: ShadowLookup, request: &Lookup) -> ShadowLookup {
    let &Lookup { footprint, level, bias, .. } = request;
    let bias = Bias::Depth(bias.unwrap_or(0.0));
    lookup.with_footprint(footprint).with_level(level).with_bias(bias)
}

/// The light that reaches each point: 1 outside the map, behind the camera and
/// for NaN. Without `world`, points are in raster space already.
fn lights<F: VisibilityField>(
    pyramid: &Pyramid<F>,
    world: &Option<ShadowLookup>,
    request: &Lookup,
    points: &[[f64; 3]],
) -> Result<Vec<F::Value>, F::Error> {
    let mut lights = Vec::with_capacity(points.len());
    match world {
        Some(lookup) => {
            let shaded = |&point: &[f64; 3]| ShadedPoint {
                position: point.into(),
                facing: Facing::Light,
                seed: 0,
            };
            let points: Vec<_> = points.iter().map(shaded).collect();
            lookup.lights(pyramid, &points, &mut lights)?;
        }
        None => {
            for point in points {
                let [x, y, depth] = point.map(|coordinate| coordinate as f32);
                let bias = request.bias.unwrap_or(0.0);
                let receiver = Receiver { bias, ..Receiver::new([x, y], depth) };
                lights.push(pyramid.lookup(&receiver, &request.footprint, request.level)?);
            }
        }
    }
    Ok(lights)
}

/// A deep map's file, and how it is asked.
struct Shadow<'a, T> {
    cursors: CursorPool<T>,
    world: Option<ShadowLookup>,
    request: &'a Lookup,
}

impl<'a, T: Transmittance> Shadow<'a, T> {
    fn new(map: CachedMap<T>, request: &'a Lookup) -> Result<Self> {
        let world = match request.space {
            Space::World => Some(set(filtering::shadow_lookup(&map)?, request)),
            Space::Raster => None,
        };
        let cursors = filtering::cursors(map, &request.footprint, request.level)?;
        Ok(Self { cursors, world, request })
    }

    fn lights(&self, points: &[[f64; 3]]) -> Result<Vec<T>> {
        Ok(self
            .cursors
            .with_pyramid(|pyramid| lights(pyramid, &self.world, self.request, points))?)
    }
}
