//! The smallest tolerance whose file keeps to a size.

use std::ops::ControlFlow;
use std::path::Path;

use dsm_core::detail::Quantization;
use dsm_core::{Progress, Tolerance};

use super::report::ImportReport;
use super::source::MapSource;
use super::tiles::{ConvertOptions, convert};
use crate::error::{Error, Result};

/// The largest tolerance that is tried.
const MOST: f32 = 0.5;

/// The smallest above 0.
const LEAST: f32 = Quantization::MIN_TOLERANCE;

/// How often the stretch between a tolerance that is too small and one that is not is
/// halved, by its logarithm: what is found is within a twentieth of the smallest.
const HALVINGS: usize = 8;

/// Makes a `.dsm` map of at most `bytes` bytes at `output`, under the smallest tolerance
/// from that of `options` on for which one is found: by halves, to a twentieth. The report
/// of the conversion, and that tolerance, beside what the source states already.
///
/// As [`convert`] in memory and in what it makes, about ten times over: trials lie in
/// files beside `output`, one at a time, which go.
///
/// # Errors
///
/// Those of [`convert`], and [`Error::Size`] if the map takes more at a tolerance of ½.
pub fn convert_to_size(
    source: &mut MapSource,
    output: &Path,
    options: &ConvertOptions,
    bytes: u64,
    mut progress: impl FnMut(Progress) -> ControlFlow<()>,
) -> Result<(ImportReport, Tolerance)> {
    let folder = folder_beside(output)?;
    let trial = folder.path().join("trial.dsm");
    let steps = HALVINGS as u64 + 3;
    let mut size_at = |tolerance: Tolerance, done: u64| {
        let options = ConvertOptions { tolerance, ..options.clone() };
        let watch = |at: Progress| {
            let total = at.total * steps;
            progress(Progress::new(at.total * done + at.done, total))
        };
        convert(source, &trial, &options, watch)?;
        let length = std::fs::metadata(&trial).map_err(Error::io("measure"));
        Ok::<u64, Error>(length.map_err(|error| error.in_file(trial.as_path()))?.len())
    };
    let least = options.tolerance;
    let mut found = least;
    if size_at(least, 0)? > bytes {
        let mut below = least.epsilon().max(LEAST);
        found = Tolerance::new(MOST.max(below))?;
        let smallest = size_at(found, 1)?;
        if smallest > bytes {
            return Err(Error::Size { asked: bytes, least: smallest });
        }
        for halving in 0..HALVINGS {
            let middle = Tolerance::new((below * found.epsilon()).sqrt())?;
            if size_at(middle, 2 + halving as u64)? > bytes {
                below = middle.epsilon();
            } else {
                found = middle;
            }
        }
    }
    let options = ConvertOptions { tolerance: found, ..options.clone() };
    let watch =
        |at: Progress| progress(Progress::new(at.total * (steps - 1) + at.done, at.total * steps));
    Ok((convert(source, output, &options, watch)?, found))
}

/// A folder beside a file that is to be written, which goes when it is dropped.
pub(crate) fn folder_beside(output: &Path) -> Result<tempfile::TempDir> {
    let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty());
    tempfile::tempdir_in(folder.unwrap_or(Path::new(".")))
        .map_err(|error| Error::io("make a folder for trials")(error).in_file(output))
}
