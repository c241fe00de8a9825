//! `lookup`: the light that reaches points.

use std::error::Error;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use dsm_core::{Footprint, MapInfo, Receiver, VisibilityField, filtered_lookup};
use dsm_io::{AnyDeepMap, Limits, MapReader};
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

/// What `--stats` prints.
#[derive(Serialize)]
struct Statistics {
    points: u64,
    /// Rays that were traced: a filter needs none.
    rays: u64,
    /// Seconds to open and read the map.
    open_s: f64,
    /// Seconds to project the points and filter the map.
    lookup_s: f64,
}

pub(crate) fn run(request: &Lookup) -> Result<()> {
    with_threads(request.effort.threads, || {
        let start = Instant::now();
        let reader = MapReader::open(&request.map, &Limits::default())?;
        let map = AnyDeepMap::read(&reader, 0)?;
        let open_s = start.elapsed().as_secs_f64();
        let (points, time) = match &map {
            AnyDeepMap::Mono(map) => answer_all(map, map.info(), request),
            AnyDeepMap::Rgb(map) => answer_all(map, map.info(), request),
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
fn answer_all<F>(field: &F, info: &MapInfo, request: &Lookup) -> Result<(u64, Duration)>
where
    F: VisibilityField<Error: Error + Send + Sync + 'static> + Sync,
{
    let path = request.points.as_path();
    let shadow =
        Shadow::new(field, info, request).with_context(|| format!("{}", request.map.display()))?;
    let mut points = open(path)?;
    let mut output = BufWriter::new(io::stdout().lock());
    output.write_all(light::header::<F::Value>())?;
    let (mut count, mut time) = (0, Duration::ZERO);
    let mut chunk = Vec::new();
    loop {
        points.read(&mut chunk, CHUNK).with_context(|| format!("{}", path.display()))?;
        if chunk.is_empty() {
            break;
        }
        let start = Instant::now();
        let answer = |point| shadow.light(point);
        let values: Vec<F::Value> =
            chunk.par_iter().with_min_len(TASK).map(answer).collect::<Result<_>>()?;
        time += start.elapsed();
        let lines: Vec<Vec<u8>> = values
            .par_chunks(TASK)
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
struct Shadow<'a, F> {
    field: &'a F,
    /// `None`: points are in raster space already.
    world: Option<WorldToRaster>,
    footprint: Footprint,
    bias: f32,
}

impl<'a, F> Shadow<'a, F>
where
    F: VisibilityField<Error: Error + Send + Sync + 'static>,
{
    fn new(field: &'a F, info: &MapInfo, request: &Lookup) -> Result<Self> {
        let world = match request.space {
            Space::World => Some(WorldToRaster::new(info, field.size())?),
            Space::Raster => None,
        };
        Ok(Self { field, world, footprint: request.footprint, bias: request.bias })
    }

    /// The light that reaches a point: 1 outside the map, behind the camera
    /// and for NaN.
    fn light(&self, point: &[f64; 3]) -> Result<F::Value> {
        let raster = match &self.world {
            Some(world) => world.project((*point).into())?.map(|raster| raster.to_array()),
            None => Some(*point),
        };
        let Some(raster) = raster else { return Ok(dsm_core::Transmittance::CLEAR) };
        let [x, y, depth] = raster.map(|coordinate| coordinate as f32);
        let receiver = Receiver { bias: self.bias, ..Receiver::new([x, y], depth) };
        Ok(filtered_lookup(self.field, &receiver, &self.footprint)?)
    }
}
