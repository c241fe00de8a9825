//! `lookup`: the light that reaches points.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use dsm_core::{
    AreaLight, Bias, Facing, Footprint, LevelChoice, LightExtent, Pyramid, Receiver, Rgb,
    ShadedPoint, ShadowLookup, Transmittance, VisibilityField,
};
use dsm_io::{CachedMap, CursorPool, Deep, ErasedMap, FieldKind, KindReader, MapKind, TileCache};
use dsm_trace::{LightFrame, TraceStatistics};
use glam::DVec3;
use mtsm::{Layers, Mtsm};
use rayon::prelude::*;
use serde::Serialize;

use crate::args::{Lookup, MethodName, Space};
use crate::layered::{self, AreaMethod, AreaShadow, AreaVisitor};
use crate::output::light;
use crate::parallel::with_threads;
use crate::points::PointReader;
use crate::{filtering, kinds};

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
        let map = kinds::open(&request.map)?;
        if map.kind() != Deep::NAME {
            return run_layered(map, request, start);
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
        filter::<Deep>(map, request, start)
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

fn run_layered(map: Box<dyn ErasedMap>, request: &Lookup, start: Instant) -> Result<()> {
    let rays = request.rays.unwrap_or(256);
    let bias = request.bias.map(f64::from);
    let method = match request.method {
        Some(MethodName::Filter) => {
            return match map.kind() {
                Mtsm::NAME => filter::<Mtsm>(map, request, start),
                Layers::NAME => filter::<Layers>(map, request, start),
                kind => bail!("{}: maps of kind {kind} are traced", request.map.display()),
            };
        }
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
    let light = layered::light_extent(&*map, request.light_size)?;
    layered::with_shadow(map, method, AnswerArea { request, light, start })
}

/// Answers points by filtered lookups in a map of kind `K`: of layers by all of
/// them, or by the first runs.
fn filter<K: FieldKind>(map: Box<dyn ErasedMap>, request: &Lookup, start: Instant) -> Result<()> {
    let cache = TileCache::new(filtering::TILE_BYTES);
    let map: KindReader<K> = map.downcast()?;
    if map.metadata().channels == 1 {
        answer_cached::<f32, K>(cache.insert(map)?, request, start)
    } else {
        answer_cached::<Rgb, K>(cache.insert(map)?, request, start)
    }
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
            done?;
            Ok(lights)
        })?;
        let traced =
            Traced { statistics: Some(shadow.statistics()), far_table: shadow.has_far_table() };
        print_statistics(request, points, time, open_s, traced)
    }
}

/// Answers points by filtered lookups in a map's file.
fn answer_cached<T: Transmittance, K: FieldKind>(
    map: CachedMap<T, K>,
    request: &Lookup,
    start: Instant,
) -> Result<()> {
    let open_s = start.elapsed().as_secs_f64();
    let shadow = Shadow::new(map, request).with_context(|| format!("{}", request.map.display()))?;
    let (points, time) = answer_all(request, |_, points| shadow.lights(points))?;
    print_statistics(request, points, time, open_s, Traced::default())
}

/// Answers every point of the file, on stdout, by asking `lights` for some at a
/// time, with the number of the first. Returns how many there were, and how long
/// their lookups took.
fn answer_all<T: Transmittance>(
    request: &Lookup,
    lights: impl Fn(u64, &[[f64; 3]]) -> Result<Vec<T>> + Sync,
) -> Result<(u64, Duration)> {
    let path = request.points.as_path();
    let mut points = open(path)?;
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
    output.flush()?;
    Ok((count, time))
}

fn open(path: &Path) -> Result<PointReader<File>> {
    let file = File::open(path).with_context(|| format!("cannot open {}", path.display()))?;
    PointReader::new(file).with_context(|| format!("{}", path.display()))
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

/// A map's file, and how it is asked.
struct Shadow<'a, T: Transmittance, K: FieldKind> {
    cursors: CursorPool<T, K>,
    world: Option<ShadowLookup>,
    request: &'a Lookup,
}

impl<'a, T: Transmittance, K: FieldKind> Shadow<'a, T, K> {
    fn new(map: CachedMap<T, K>, request: &'a Lookup) -> Result<Self> {
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
