//! `lookup`: the light that reaches points.

use std::fs::File;
use std::io::{self, BufWriter, IsTerminal, Read, Write};
use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, anyhow};
use deepshadow::files::detail::AtomicFile;
use deepshadow::glam::DVec3;
use deepshadow::visibility::Progress;
use deepshadow::{Method, OpenOptions, Query, Shadow, Values};
use indicatif::ProgressBar;
use rayon::prelude::*;
use serde::Serialize;

use crate::args::{Lookup, Points, Space};
use crate::in_map::{InMap, empty_is, is_empty, is_part};
use crate::input::STREAM;
use crate::output::progress::Watch;
use crate::output::warnings::Warnings;
use crate::output::{light, progress};
use crate::parallel::with_threads;
use crate::points::PointReader;
use crate::positions::source::PositionPicture;
use crate::positions::target;
use crate::wide_light;

/// Points that are in memory at a time.
const CHUNK: usize = 1 << 16;
/// Points that are answered by one task, and whose lines one task writes.
const TASK: usize = 1 << 10;

/// The counts that `--stats` prints.
#[derive(Serialize)]
struct Statistics<'a> {
    points: u64,
    /// Rays that were traced: a filter needs none.
    rays: u64,
    /// Seconds to open the map and make it ready.
    open_s: f64,
    /// Seconds to project the points, read tiles and filter or trace.
    lookup_s: f64,
    /// Rays that left the map at its depths.
    #[serde(skip_serializing_if = "Option::is_none")]
    rays_outside_map: Option<u64>,
    /// Rays of points that lie no deeper than the light.
    #[serde(skip_serializing_if = "Option::is_none")]
    points_behind_light: Option<u64>,
    /// True if a far table was used.
    #[serde(skip_serializing_if = "Option::is_none")]
    far_table: Option<bool>,
    warnings: &'a Warnings,
}

pub(crate) fn run(request: &Lookup) -> Result<()> {
    with_threads(request.effort.threads, || {
        let start = Instant::now();
        let map = OpenOptions::new().open(&request.map)?;
        let in_map = |reason: String| anyhow!("{}: {reason}", request.map.display());
        let method = request.method(map.default_method()).map_err(in_map)?;
        if request.space == Space::World && map.info().camera.is_none() {
            let reason = "the map has no camera to project points of the world with";
            return Err(in_map(reason.to_owned()));
        }
        let mut query = Query::new().with_method(method).with_seed(request.seed);
        query.light_size = request.light_size;
        let shadow = match &request.near {
            Some(near) => {
                let near = OpenOptions::new().open(near)?;
                map.hybrid_shadow_of_maps(&near, &query)?
            }
            None => map.shadow(&query)?,
        };
        let open_s = start.elapsed().as_secs_f64();
        let seen = InMap::new(map.view()?);
        let (points, nan, time) = match &request.points {
            Points::Csv(path) => answer_all(request, path, &shadow, &seen)?,
            Points::Picture { positions, output } => {
                let (points, time) = answer_picture(request, positions, output, (&shadow, &seen))?;
                (points, None, time)
            }
        };
        let mut warnings = Warnings::new(request.strict).in_document(request.stats);
        if is_empty(&map)? && !is_part(&map) {
            warnings.add(format!("the map holds nothing: it is {}", empty_is(map.kind())));
        }
        warnings.extend(seen.warning());
        warnings.extend(map.container().remark());
        if let Some((line, count)) = nan {
            let are = if count == 1 { "point has" } else { "points have" };
            warnings.add(format!(
                "{count} {are} a coordinate that is no number (NaN), and is lit: point {line} is the first"
            ));
        }
        if let Method::Filter(_) = method {
            warnings.extend(wide_light::of_map(&map)?);
        }
        if request.stats {
            let found = shadow.statistics();
            let statistics = Statistics {
                points,
                rays: found.rays.map_or(0, |rays| rays.rays),
                open_s,
                lookup_s: time.as_secs_f64(),
                rays_outside_map: found.rays.map(|rays| rays.outside_map),
                points_behind_light: found.rays.map(|rays| rays.behind_light),
                far_table: found.far_table,
                warnings: &warnings,
            };
            writeln!(io::stderr(), "{}", serde_json::to_string(&statistics)?)?;
        }
        warnings.finish()
    })
}

/// The number of the first point with a NaN, counted from 1, and how many there are.
type NanPoints = Option<(u64, u64)>;

/// Answers every point of the file on stdout. Returns how many there were, which have a NaN, and
/// how long their lookups took.
fn answer_all(
    request: &Lookup,
    path: &Path,
    shadow: &Shadow,
    seen: &InMap,
) -> Result<(u64, NanPoints, Duration)> {
    let (mut points, bar) = open(path, request.quiet)?;
    let mut output = BufWriter::new(io::stdout().lock());
    output.write_all(light::header(shadow.channels()))?;
    let (mut count, mut nan, mut time) = (0_u64, NanPoints::None, Duration::ZERO);
    let mut chunk = Vec::new();
    loop {
        points.read(&mut chunk, CHUNK).with_context(|| format!("{}", path.display()))?;
        if chunk.is_empty() {
            break;
        }
        for (index, _) in (1..).zip(&chunk).filter(|(_, at)| at.iter().any(|at| at.is_nan())) {
            let (first, sum) = nan.unwrap_or((count + index, 0));
            nan = Some((first, sum + 1));
        }
        let start = Instant::now();
        let values = match request.space {
            Space::World => {
                let points: Vec<DVec3> = chunk.iter().copied().map(DVec3::from).collect();
                seen.see_world(points.iter().copied());
                shadow.query_from(&points, count)
            }
            Space::Raster => {
                seen.see_raster(&chunk);
                shadow.query_raster(&chunk, count)
            }
        }?;
        time += start.elapsed();
        write_lines(&values, &mut output)?;
        count += chunk.len() as u64;
    }
    bar.finish_and_clear();
    output.flush()?;
    Ok((count, nan, time))
}

/// Answers every pixel of a picture with a picture. Holds a band of rows.
fn answer_picture(
    request: &Lookup,
    path: &Path,
    output: &Path,
    (shadow, seen): (&Shadow, &InMap),
) -> Result<(u64, Duration)> {
    let picture = PositionPicture::open(path).with_context(|| format!("{}", path.display()))?;
    let [width, height] = picture.size();
    let watch = Watch::start("looking up", request.quiet)?;
    let mut file = AtomicFile::create(output)?;
    let mut time = Duration::ZERO;
    let (mut row, mut number) = (0, 0_u64);
    let mut waiting: Vec<DVec3> = Vec::new();
    target::write(&mut file, &picture, shadow.channels(), || {
        if watch.at(Progress::new(row as u64, height as u64)).is_break() {
            return Err(anyhow!("interrupted"));
        }
        while row < height && waiting.len() < TASK {
            waiting.append(&mut picture.read(row)?);
            row += picture.band();
        }
        // In the tasks of one long list, whatever the rows: some methods answer neighbours
        // together.
        let count = if row < height { waiting.len() / TASK * TASK } else { waiting.len() };
        let points: Vec<DVec3> = waiting.drain(..count).collect();
        let start = Instant::now();
        let values = match request.space {
            Space::World => {
                seen.see_world(points.iter().copied());
                shadow.query_from(&points, number)
            }
            Space::Raster => {
                let points: Vec<[f64; 3]> = points.iter().map(DVec3::to_array).collect();
                seen.see_raster(&points);
                shadow.query_raster(&points, number)
            }
        }?;
        time += start.elapsed();
        number += count as u64;
        Ok(values)
    })?;
    file.commit(&[])?;
    drop(watch);
    Ok((width as u64 * height as u64, time))
}

fn write_lines(values: &Values, output: &mut impl Write) -> Result<()> {
    let first = (0..values.len()).into_par_iter().step_by(TASK);
    let lines: Vec<Vec<u8>> = first
        .map(|first| {
            let mut lines = Vec::with_capacity(TASK * 12);
            for point in first..values.len().min(first + TASK) {
                light::append_line(&values.rgb(point)[..values.channels()], &mut lines);
            }
            lines
        })
        .collect();
    lines.iter().try_for_each(|lines| Ok(output.write_all(lines)?))
}

/// Opens the points. The bar shows how many of their bytes are read, unless the
/// answers fill the terminal.
fn open(path: &Path, quiet: bool) -> Result<(PointReader<impl Read>, ProgressBar)> {
    let (file, bytes): (Box<dyn Read>, u64) = if path.as_os_str() == STREAM {
        (Box::new(io::stdin()), 0)
    } else {
        let file = File::open(path).with_context(|| format!("cannot open {}", path.display()))?;
        let bytes = file.metadata().map_or(0, |metadata| metadata.len());
        (Box::new(file), bytes)
    };
    let quiet = quiet || io::stdout().is_terminal();
    let bar = progress::bar(bytes, "looking up".to_owned(), quiet);
    let points = PointReader::new(bar.wrap_read(file));
    Ok((points.with_context(|| format!("{}", path.display()))?, bar))
}
