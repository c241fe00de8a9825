//! How far a map is from what it stands for.

use std::ops::Range;

use dsm_core::{DifferenceSummary, Rgb, Tolerance, Transmittance, VisibilityDifference};
use rayon::prelude::*;

use super::rows::ExactFunction;
use super::{ImportReport, MapSource};
use crate::{AchievedError, Error, MapReader, Result};

/// Rows that are compared at a time: bounds the memory.
const BAND: u32 = 64;

/// Pixels that one task compares.
const CHUNK: usize = 1024;

/// The difference of two files of one size.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MapDifference {
    /// The mean of the pixels' means; see
    /// [`VisibilityDifference::mean`](dsm_core::VisibilityDifference::mean).
    pub mean: f64,
    /// The largest difference of any pixel, depth and channel, and where it
    /// stands; `None` if there is no difference.
    pub worst: Option<WorstPixel>,
}

impl MapDifference {
    /// The largest difference; 0 if there is none.
    #[must_use]
    pub fn max(&self) -> f64 {
        self.worst.map_or(0.0, |worst| worst.difference)
    }
}

/// Where two maps differ the most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorstPixel {
    /// Column.
    pub x: u32,
    /// Row.
    pub y: u32,
    /// Depth.
    pub z: f32,
    /// Channel: 0, or 0 to 2 for coloured maps.
    pub channel: usize,
    /// The absolute difference there.
    pub difference: f64,
}

/// Compares level 0 of two files, pixel by pixel, exactly but for the chords
/// of curved stretches (5e-7). `progress` is told how many rows are done.
///
/// # Errors
///
/// [`Error::Caller`] if their sizes or channels differ; else what keeps one
/// of them from being read.
pub fn compare(
    a: &mut MapSource,
    b: &mut MapSource,
    mut progress: impl FnMut(u32),
) -> Result<MapDifference> {
    let [width, height] = a.size();
    if b.size() != [width, height] {
        let [other_width, other_height] = b.size();
        return Err(Error::caller(format!(
            "the sizes differ: {width} × {height} and {other_width} × {other_height} pixels"
        )));
    }
    if a.channels() != b.channels() {
        let (a, b) = (a.channels(), b.channels());
        return Err(Error::caller(format!("the numbers of channels differ: {a} and {b}")));
    }
    let mut summary = DifferenceSummary::default();
    for top in (0..height).step_by(BAND as usize) {
        let rows = top..top.saturating_add(BAND).min(height);
        let band = if a.channels() == 1 {
            compare_rows::<f32>(a, b, width, rows.clone())
        } else {
            compare_rows::<Rgb>(a, b, width, rows.clone())
        }?;
        summary.merge(&band);
        progress(rows.end);
    }
    let worst = summary.worst().filter(|(_, difference)| difference.max() > 0.0);
    Ok(MapDifference {
        mean: summary.mean(),
        worst: worst.map(|(pixel, difference)| WorstPixel {
            x: (pixel % width as usize) as u32,
            y: (pixel / width as usize) as u32,
            z: difference.depth(),
            channel: difference.channel(),
            difference: difference.max(),
        }),
    })
}

/// Checks that `map` keeps the bound that it states against `source`, with
/// [`AchievedError::SLACK`] for chords and rounding. Returns the difference.
///
/// # Errors
///
/// [`Error::Bound`] if it doesn't; else as [`compare`].
pub fn check_bound(
    map: MapReader,
    source: &mut MapSource,
    progress: impl FnMut(u32),
) -> Result<MapDifference> {
    let stated = map.metadata().info.tolerance.epsilon();
    let difference = compare(&mut MapSource::Map(Box::new(map)), source, progress)?;
    let bound = f64::from(stated) + f64::from(AchievedError::SLACK);
    match difference.worst {
        Some(worst) if worst.difference > bound => Err(Error::Bound { stated, worst }),
        _ => Ok(difference),
    }
}

fn compare_rows<T: Transmittance>(
    a: &mut MapSource,
    b: &mut MapSource,
    width: u32,
    rows: Range<u32>,
) -> Result<DifferenceSummary> {
    let first_pixel = rows.start as usize * width as usize;
    let pixels = rows.len() * width as usize;
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
                summary.add(first_pixel + pixel, VisibilityDifference::between(a, b));
            }
            Ok(summary)
        })
        .collect::<Result<_>>()?;
    let mut summary = DifferenceSummary::default();
    chunks.iter().for_each(|chunk| summary.merge(chunk));
    Ok(summary)
}
