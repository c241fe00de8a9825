//! Differences between a map and what it stands for.

use std::ops::ControlFlow;
use std::ops::Range;

use dsm_core::detail::{DifferenceSummary, VisibilityDifference};
use dsm_core::{Progress, Rgb, Tolerance, Transmittance, VisibilityFunction};
use rayon::prelude::*;

use super::report::ImportReport;
use super::rows::ExactFunction;
use super::source::MapSource;
use crate::achieved_error::AchievedError;
use crate::blocks::{BLOCKS_A_THREAD, Blocks, is_empty, stated_depth_error};
use crate::error::{Error, Result};
use crate::format::level::Level;
use crate::progress::{Watch, tell};
use crate::reader::MapReader;
use crate::region::Region;
use crate::tile_id::TileRect;
use crate::worst_pixel::WorstPixel;

/// Rows of images that are compared at a time: bounds the memory.
const BAND: u32 = 64;

/// Pixels that one task compares.
const CHUNK: usize = 1024;

/// What two functions of a pixel are compared by.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Measure {
    /// Their difference.
    Difference,
    /// How far the first is from the second where its depths may have been
    /// moved as far as its tiles state.
    Bound,
}

/// The difference of two files of one size, as [`compare`] measures it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MapDifference {
    /// The mean of the pixels' means, over all levels; see
    /// [`VisibilityDifference::mean`](dsm_core::detail::VisibilityDifference::mean).
    pub mean: f64,
    /// The largest difference of any pixel, depth and channel, and where it
    /// stands; `None` if there is no difference.
    pub worst: Option<WorstPixel>,
}

impl MapDifference {
    /// The difference of levels, by their indices and widths.
    fn of_levels(levels: impl IntoIterator<Item = (u32, u32, DifferenceSummary)>) -> Self {
        let (mut difference, mut sum, mut pixels) = (Self::default(), 0.0, 0);
        for (level, width, summary) in levels {
            sum += summary.mean() * summary.pixels() as f64;
            pixels += summary.pixels();
            let worst = summary.worst().filter(|(_, worst)| worst.max() > difference.max());
            difference.worst = worst.map_or(difference.worst, |(pixel, worst)| {
                Some(WorstPixel {
                    level,
                    x: (pixel % width as usize) as u32,
                    y: (pixel / width as usize) as u32,
                    z: worst.depth(),
                    channel: worst.channel(),
                    difference: worst.max(),
                })
            });
        }
        difference.mean = if pixels == 0 { 0.0 } else { sum / pixels as f64 };
        difference
    }

    /// The largest difference; 0 if there is none.
    #[must_use]
    pub fn max(&self) -> f64 {
        self.worst.map_or(0.0, |worst| worst.difference)
    }
}

/// Compares level 0 of two files, pixel by pixel, exactly but for the chords
/// of curved stretches (5e-7). `progress` is told how many rows are done.
///
/// Memory: of maps a few tiles a thread, of images a band of rows. Where two
/// maps have empty tiles, they cost nothing.
///
/// ```
/// use dsm_core::{DeepMap, MapInfo, PixelListsBuilder, Progress, Vertex};
/// use dsm_io::detail::compare;
/// use dsm_io::{Limits, MapSource, Metadata, WriteOptions, write_map};
/// # use dsm_io::AchievedError;
///
/// // Two maps of one pixel, of half and a quarter of the light past depth 2.
/// let folder = tempfile::tempdir()?;
/// let mut maps = Vec::new();
/// for left in [0.5, 0.25] {
///     let mut pixels = PixelListsBuilder::<f32>::new(1, 1);
///     pixels.push(Vertex::new(2.0, 1.0));
///     pixels.push(Vertex::new(2.0, left));
///     pixels.finish_pixel()?;
///     let map = DeepMap::new(MapInfo::default(), pixels.finish()?);
///     let path = folder.path().join(format!("{left}.dsm"));
///     let metadata = Metadata::new(1, 1, 1, MapInfo::default());
///     write_map(&path, metadata, &map, AchievedError::NONE, WriteOptions::default())?;
///     maps.push(MapSource::open(&path, None, &Limits::default())?);
/// }
/// let [one, other] = &mut maps[..] else { unreachable!() };
/// let difference = compare(one, other, Progress::ignore)?;
/// assert_eq!(difference.max(), 0.25);
/// assert_eq!(difference.worst.map(|worst| worst.z), Some(2.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// [`Error::Mismatch`] if their sizes or channels differ; else what keeps one
/// of them from being read.
pub fn compare(
    a: &mut MapSource,
    b: &mut MapSource,
    mut progress: impl FnMut(Progress) -> ControlFlow<()>,
) -> Result<MapDifference> {
    measure(a, b, Measure::Difference, &mut progress)
}

fn measure(
    a: &mut MapSource,
    b: &mut MapSource,
    by: Measure,
    progress: Watch<'_>,
) -> Result<MapDifference> {
    check_alike(a, b)?;
    match (&*a, &*b) {
        (MapSource::Map(a), MapSource::Map(b)) => {
            let summary = compare_maps(a, b, 0, by, progress)?;
            Ok(MapDifference::of_levels([(0, a.metadata().width, summary)]))
        }
        _ => compare_rows_of(a, b, by, progress),
    }
}

/// Compares two files as [`compare`] does, of two maps all levels that both
/// have. The mean is over the pixels of all. `progress` is told how many rows
/// are done, and of how many.
///
/// # Errors
///
/// As [`compare`]; also if levels of one number have other sizes, or the two
/// are other parts of a map.
pub fn compare_levels(
    a: &mut MapSource,
    b: &mut MapSource,
    mut progress: impl FnMut(Progress) -> ControlFlow<()>,
) -> Result<MapDifference> {
    check_alike(a, b)?;
    let (MapSource::Map(a), MapSource::Map(b)) = (&*a, &*b) else {
        let by = Measure::Difference;
        return compare_rows_of(a, b, by, &mut progress);
    };
    if let (Some(one), Some(other)) = (a.crop(), b.crop())
        && one != other
    {
        return Err(Error::mismatch("they are other parts of a map"));
    }
    let common: Vec<(u32, &Level, &Level)> = (0..)
        .zip(a.levels().iter().zip(b.levels()))
        .map(|(index, (a, b))| (index, a, b))
        .take_while(|(_, a, b)| [a.view, a.number] == [b.view, b.number])
        .collect();
    for (index, a, b) in &common {
        if [a.width, a.height] != [b.width, b.height] {
            return Err(Error::mismatch(format!(
                "the sizes of level {index} differ: {} × {} and {} × {} pixels",
                a.width, a.height, b.width, b.height
            )));
        }
    }
    let total = common.iter().map(|(_, level, _)| u64::from(level.height)).sum();
    let (mut before, mut levels) = (0, Vec::new());
    for (index, level, _) in &common {
        let rows_done = &mut |rows: Progress| progress(Progress::new(before + rows.done, total));
        let summary = compare_maps(a, b, *index, Measure::Difference, rows_done)?;
        levels.push((*index, level.width, summary));
        before += u64::from(level.height);
    }
    Ok(MapDifference::of_levels(levels))
}

/// Refuses files of other sizes or numbers of channels.
fn check_alike(a: &MapSource, b: &MapSource) -> Result<()> {
    let ([width, height], [other_width, other_height]) = (a.size(), b.size());
    if [width, height] != [other_width, other_height] {
        return Err(Error::mismatch(format!(
            "the sizes differ: {width} × {height} and {other_width} × {other_height} pixels"
        )));
    }
    if a.channels() != b.channels() {
        let (a, b) = (a.channels(), b.channels());
        return Err(Error::mismatch(format!("the numbers of channels differ: {a} and {b}")));
    }
    Ok(())
}

/// Compares files of which one is an image, a band of rows at a time.
fn compare_rows_of(
    a: &mut MapSource,
    b: &mut MapSource,
    by: Measure,
    progress: Watch<'_>,
) -> Result<MapDifference> {
    let [width, height] = a.size();
    let mut summary = DifferenceSummary::default();
    for top in (0..height).step_by(BAND as usize) {
        let rows = top..top.saturating_add(BAND).min(height);
        let band = if a.channels() == 1 {
            compare_rows::<f32>(a, b, by, width, rows.clone())
        } else {
            compare_rows::<Rgb>(a, b, by, width, rows.clone())
        }?;
        summary.merge(&band);
        tell(progress, rows.end, height)?;
    }
    Ok(MapDifference::of_levels([(0, width, summary)]))
}

/// Compares levels of one size, a few blocks of tiles at a time.
fn compare_maps(
    a: &MapReader,
    b: &MapReader,
    index: u32,
    by: Measure,
    progress: Watch<'_>,
) -> Result<DifferenceSummary> {
    let (level, other) = (a.container().level(index)?, b.container().level(index)?);
    let blocks = Blocks::new(level, [other]);
    let mut summary = DifferenceSummary::default();
    let batch = BLOCKS_A_THREAD * rayon::current_num_threads() as u64;
    for start in (0..blocks.count()).step_by(batch as usize) {
        let end = start.saturating_add(batch).min(blocks.count());
        // Merged in order: the same sums with any number of threads.
        let compared = (start..end)
            .into_par_iter()
            .map(|block| {
                let rect = blocks.rect(block);
                if a.metadata().channels == 1 {
                    compare_block::<f32>(a, b, index, by, rect)
                } else {
                    compare_block::<Rgb>(a, b, index, by, rect)
                }
            })
            .collect::<Result<Vec<_>>>()?;
        compared.iter().for_each(|block| summary.merge(block));
        let last = blocks.rect(end - 1);
        tell(progress, last.y + last.height, level.height)?;
    }
    Ok(summary)
}

fn compare_block<T: Transmittance>(
    a: &MapReader,
    b: &MapReader,
    index: u32,
    by: Measure,
    rect: TileRect,
) -> Result<DifferenceSummary> {
    let mut summary = DifferenceSummary::default();
    if is_empty(a, index, rect)? && is_empty(b, index, rect)? {
        summary.add_equal(rect.pixel_count() as usize);
        return Ok(summary);
    }
    let width = a.container().level(index)?.width as usize;
    let depth_error = match by {
        Measure::Difference => 0.0,
        Measure::Bound => stated_depth_error(a, index, rect)?,
    };
    let (a, b) = (Region::<T>::read(a, index, rect)?, Region::<T>::read(b, index, rect)?);
    let clear = VisibilityFunction::<T>::clear();
    let rows: Vec<_> = (rect.y..rect.y + rect.height)
        .into_par_iter()
        .map(|y| {
            let mut row = DifferenceSummary::default();
            for x in rect.x..rect.x + rect.width {
                let (a, b) = match (a.function(x, y), b.function(x, y)) {
                    (None, None) => {
                        row.add_equal(1);
                        continue;
                    }
                    (a, b) => (a.unwrap_or(clear.view()), b.unwrap_or(clear.view())),
                };
                let pixel = y as usize * width + x as usize;
                let difference = VisibilityDifference::with_moved_depths(&a, &b, depth_error);
                row.add(pixel, difference);
            }
            row
        })
        .collect();
    rows.iter().for_each(|row| summary.merge(row));
    Ok(summary)
}

/// Checks that `map` keeps the bound that it states against `source`, with
/// [`AchievedError::SLACK`] for chords and rounding: V(z) − ε ≤ V′(z) ≤
/// V₋(z − δ) + ε where depths were moved away from the light by up to the δ that
/// its tiles state. Returns how far it is from the source, so measured
/// ([`VisibilityDifference::with_moved_depths`]).
///
/// # Errors
///
/// [`Error::Bound`] if it doesn't; else as [`compare`].
pub fn check_bound(
    map: MapReader,
    source: &mut MapSource,
    mut progress: impl FnMut(Progress) -> ControlFlow<()>,
) -> Result<MapDifference> {
    let stated = map.metadata().info.tolerance.epsilon();
    let map = &mut MapSource::Map(Box::new(map));
    let difference = measure(map, source, Measure::Bound, &mut progress)?;
    let bound = f64::from(stated) + f64::from(AchievedError::SLACK);
    match difference.worst {
        Some(worst) if worst.difference > bound => Err(Error::Bound { stated, worst }),
        _ => Ok(difference),
    }
}

fn compare_rows<T: Transmittance>(
    a: &mut MapSource,
    b: &mut MapSource,
    by: Measure,
    width: u32,
    rows: Range<u32>,
) -> Result<DifferenceSummary> {
    let first_pixel = rows.start as usize * width as usize;
    let pixels = rows.len() * width as usize;
    let depth_error = match by {
        Measure::Difference => 0.0,
        Measure::Bound => a.stated_depth_error(rows.clone())?,
    };
    let (a, b) = (a.read_rows::<T>(rows.clone())?, b.read_rows::<T>(rows)?);
    let chord_error = Tolerance::EXACT.chord();
    // Chunks of a fixed size, merged in order: the same sums on any machine.
    let chunks: Vec<_> = (0..pixels)
        .step_by(CHUNK)
        .collect::<Vec<_>>()
        .into_par_iter()
        .map(|start| {
            let mut summary = DifferenceSummary::default();
            let mut report = ImportReport::default();
            let mut exact = [ExactFunction::new(chord_error), ExactFunction::new(chord_error)];
            for pixel in start..(start + CHUNK).min(pixels) {
                a.function(pixel, &mut exact[0], &mut report)?;
                b.function(pixel, &mut exact[1], &mut report)?;
                let [a, b] = exact.each_ref().map(ExactFunction::vertices);
                let difference = VisibilityDifference::with_moved_depths(a, b, depth_error);
                summary.add(first_pixel + pixel, difference);
            }
            Ok(summary)
        })
        .collect::<Result<_>>()?;
    let mut summary = DifferenceSummary::default();
    chunks.iter().for_each(|chunk| summary.merge(chunk));
    Ok(summary)
}
