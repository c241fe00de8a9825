//! `lookup`: the light that reaches points.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use dsm_core::{Footprint, LevelChoice, Pyramid, Receiver, Transmittance, VisibilityField};
use dsm_io::{AnyCachedMap, CachedMap, Limits, LookupCursor, TileCache};
use rayon::prelude::*;
use serde::Serialize;

use crate::args::{Lookup, Space};
use crate::output::light;
use crate::parallel::with_threads;
use crate::points::PointReader;
use crate::raster::WorldToRaster;

/// Points that are in memory at a time.
const CHUNK: usize = 1 << 16;
/// Points that one task takes.
const TASK: usize = 1 << 10;

/// Bytes of tiles that are kept at hand: the tiles of large maps come and go,
/// and small ones stay whole.
const TILE_BYTES: u64 = 1 << 30;

/// Pixels that the filter of one point may reach: about a second's work.
const MOST_PIXELS: u64 = 1 << 26;

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
        let cache = TileCache::new(TILE_BYTES);
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
    map: CachedMap<T>,
    /// Cursors that no task uses now, with the tiles they hold.
    idle: Mutex<Vec<Pyramid<LookupCursor<T>>>>,
    /// `None`: points are in raster space already.
    world: Option<WorldToRaster>,
    footprint: Footprint,
    level: LevelChoice,
    bias: f32,
}

impl<T: Transmittance> Shadow<T> {
    fn new(map: CachedMap<T>, request: &Lookup) -> Result<Self> {
        let &Lookup { space, footprint, level, bias, .. } = request;
        let metadata = map.reader().metadata();
        let world = match space {
            Space::World => {
                Some(WorldToRaster::new(&metadata.info, [metadata.width, metadata.height])?)
            }
            Space::Raster => None,
        };
        let shadow = Self { map, idle: Mutex::default(), world, footprint, level, bias };
        let pyramid = shadow.pyramid()?;
        if let LevelChoice::Fixed(level) = level {
            match pyramid.levels().len() {
                count if level <= (count - 1) as f64 => {}
                1 => bail!("there is no level {level}: the map has one level, 0"),
                count => bail!(
                    "there is no level {level}: the map has {count} levels, 0 to {}",
                    count - 1
                ),
            }
        }
        let reached = shadow.pixels_of_a_filter(&pyramid);
        if reached > MOST_PIXELS {
            bail!(
                "the filter reaches {reached} pixels, more than the {MOST_PIXELS} of a lookup: \
                 look up a coarser level (--level)"
            );
        }
        shadow.put_back(pyramid);
        Ok(shadow)
    }

    /// About how many pixels a filter visits in the finer of its levels.
    fn pixels_of_a_filter(&self, pyramid: &Pyramid<LookupCursor<T>>) -> u64 {
        let Footprint::Isotropic(filter) = self.footprint else { return 1 };
        let width = f64::from(filter.width());
        let finest = match self.level {
            LevelChoice::Fixed(level) => level,
            LevelChoice::Auto => (width / 2.0).log2(),
        };
        let levels = pyramid.levels();
        let level = (finest.max(0.0) as usize).min(levels.len() - 1);
        let reach = width / 2.0_f64.powi(level as i32) + 1.0;
        levels[level].size().map(|size| (reach as u64).min(size.into())).iter().product()
    }

    /// Cursors over the map's levels, for one task.
    fn pyramid(&self) -> Result<Pyramid<LookupCursor<T>>> {
        let idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner).pop();
        match idle {
            Some(pyramid) => Ok(pyramid),
            None if self.level == LevelChoice::FINEST => Ok(Pyramid::new(vec![self.map.cursor()])?),
            None => Ok(self.map.pyramid()?),
        }
    }

    fn put_back(&self, pyramid: Pyramid<LookupCursor<T>>) {
        self.idle.lock().unwrap_or_else(PoisonError::into_inner).push(pyramid);
    }

    /// The light that reaches each point.
    fn lights(&self, points: &[[f64; 3]]) -> Result<Vec<T>> {
        let pyramid = self.pyramid()?;
        let lights = points.iter().map(|point| self.light(&pyramid, point)).collect();
        self.put_back(pyramid);
        lights
    }

    /// The light that reaches a point: 1 outside the map, behind the camera
    /// and for NaN.
    fn light(&self, pyramid: &Pyramid<LookupCursor<T>>, point: &[f64; 3]) -> Result<T> {
        let raster = match &self.world {
            Some(world) => world.project((*point).into())?.map(|raster| raster.to_array()),
            None => Some(*point),
        };
        let Some(raster) = raster else { return Ok(T::CLEAR) };
        let [x, y, depth] = raster.map(|coordinate| coordinate as f32);
        let receiver = Receiver { bias: self.bias, ..Receiver::new([x, y], depth) };
        Ok(pyramid.lookup(&receiver, &self.footprint, self.level)?)
    }
}
