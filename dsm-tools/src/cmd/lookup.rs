//! `lookup`: the light that reaches points.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use dsm_core::{
    Bias, Facing, Footprint, LevelChoice, Receiver, ShadedPoint, ShadowLookup, Transmittance,
};
use dsm_io::{AnyCachedMap, CachedMap, CursorPool, Limits, TileCache};
use rayon::prelude::*;
use serde::Serialize;

use crate::args::{Lookup, Space};
use crate::filtering;
use crate::output::light;
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
}

pub(crate) fn run(request: &Lookup) -> Result<()> {
    with_threads(request.effort.threads, || {
        let start = Instant::now();
        let cache = TileCache::new(filtering::TILE_BYTES);
        let map = AnyCachedMap::open(&cache, &request.map, &Limits::default())?;
        let open_s = start.elapsed().as_secs_f64();
        let (points, time) = match map {
            AnyCachedMap::Mono(map) => answer_all(map, request),
            AnyCachedMap::Rgb(map) => answer_all(map, request),
        }?;
        if request.stats {
            let statistics = Statistics { points, rays: 0, open_s, lookup_s: time.as_secs_f64() };
            writeln!(io::stderr(), "{}", serde_json::to_string(&statistics)?)?;
        }
        Ok(())
    })
}

/// Answers every point of the file, on stdout. Returns how many there were,
/// and how long their lookups took.
fn answer_all<T: Transmittance>(map: CachedMap<T>, request: &Lookup) -> Result<(u64, Duration)> {
    let path = request.points.as_path();
    let shadow = Shadow::new(map, request).with_context(|| format!("{}", request.map.display()))?;
    let mut points = open(path)?;
    let mut output = BufWriter::new(io::stdout().lock());
    output.write_all(light::header::<T>())?;
    let (mut count, mut time) = (0, Duration::ZERO);
    let mut chunk = Vec::new();
    loop {
        points.read(&mut chunk, CHUNK).with_context(|| format!("{}", path.display()))?;
        if chunk.is_empty() {
            break;
        }
        let start = Instant::now();
        let tasks = chunk.par_chunks(TASK);
        let values: Vec<Vec<T>> =
            tasks.map(|points| shadow.lights(points)).collect::<Result<_>>()?;
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

/// A map, and how it is asked.
struct Shadow<T> {
    cursors: CursorPool<T>,
    /// `None`: points are in raster space already.
    world: Option<ShadowLookup>,
    footprint: Footprint,
    level: LevelChoice,
    bias: f32,
}

impl<T: Transmittance> Shadow<T> {
    fn new(map: CachedMap<T>, request: &Lookup) -> Result<Self> {
        let &Lookup { space, footprint, level, bias, .. } = request;
        let world = match space {
            Space::World => Some(
                filtering::shadow_lookup(&map)?
                    .with_footprint(footprint)
                    .with_level(level)
                    .with_bias(Bias::Depth(bias)),
            ),
            Space::Raster => None,
        };
        let cursors = filtering::cursors(map, &footprint, level)?;
        Ok(Self { cursors, world, footprint, level, bias })
    }

    /// The light that reaches each point: 1 outside the map, behind the camera
    /// and for NaN.
    fn lights(&self, points: &[[f64; 3]]) -> Result<Vec<T>> {
        let mut lights = Vec::with_capacity(points.len());
        self.cursors.with_pyramid(|pyramid| {
            match &self.world {
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
                        let bias = self.bias;
                        let receiver = Receiver { bias, ..Receiver::new([x, y], depth) };
                        lights.push(pyramid.lookup(&receiver, &self.footprint, self.level)?);
                    }
                }
            }
            Ok::<_, dsm_io::Error>(())
        })?;
        Ok(lights)
    }
}
