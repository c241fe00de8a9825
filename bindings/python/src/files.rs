//! Maps made of maps and images, compared and checked.

use std::path::{Path, PathBuf};

use deepshadow::ShadowMap;
use deepshadow::files::detail::{MapDifference, compare_levels};
use deepshadow::files::{
    Error as FileError, ImportReport, Limits, MapReader, MapSource, MergeReport, PyramidOptions,
};
use deepshadow::visibility::Tolerance;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::convert_options::{selection, take_image, take_map, take_selection};
use crate::error::{Result, whole_message};
use crate::options::Options;
use crate::progress::run;

/// convert(source, output, *, threads=None, progress=None, **options)
/// --
///
/// Makes a map of a deep image (.exr), a flat depth image or another map; or, if output ends
/// in .exr, a deep image of a map. output is replaced when it is whole.
///
/// options, as `dsm-tools convert` has them: tolerance; part, layer, channels of an image that
/// is read; method, side, codec, depth_error, block, tile, camera_axis ("+z", "-z"), ndc ("unit", "screen")
/// of maps that are written; exr_layout, exr_type, exr_compression, tile of images.
///
/// Returns a dict: of maps samples and notes, what was clamped, dropped or assumed, a line
/// each; of images samples, max_samples, error, total_error, left_out. Raises FileError with
/// the file and the place in it, SettingError, Cancelled.
#[pyfunction]
#[pyo3(signature = (source, output, *, threads=None, progress=None, **options))]
pub(crate) fn convert<'py>(
    py: Python<'py>,
    source: PathBuf,
    output: PathBuf,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
    options: Option<&Bound<'py, PyDict>>,
) -> Result<Bound<'py, PyDict>> {
    let given = Options::new(py, options)?;
    let chosen = take_selection(&given)?;
    let progress = progress.as_ref();
    let open = || MapSource::open(&source, chosen.clone(), &Limits::default());
    if output.extension().is_some_and(|end| end.eq_ignore_ascii_case("exr")) {
        let options = take_image(&given)?;
        given.finish("convert")?;
        let report = run(py, threads, progress, |watch| {
            let mut source = open()?;
            deepshadow::files::export_deep_exr(&mut source, &output, &options, |at| watch.at(at))
        })?;
        let dict = PyDict::new(py);
        dict.set_item("samples", report.samples)?;
        dict.set_item("max_samples", report.max_samples)?;
        dict.set_item("error", report.achieved)?;
        dict.set_item("total_error", report.total)?;
        dict.set_item("left_out", report.left_out)?;
        return Ok(dict);
    }
    let options = take_map(&given)?;
    given.finish("convert")?;
    let report = run(py, threads, progress, |watch| {
        deepshadow::files::convert(&mut open()?, &output, &options, |at| watch.at(at))
    })?;
    imported(py, &report)
}

/// What an import did, as a dict.
pub(crate) fn imported<'py>(py: Python<'py>, report: &ImportReport) -> Result<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("samples", report.samples)?;
    dict.set_item("notes", report.lines())?;
    Ok(dict)
}

/// mip(source, output, *, levels=None, tolerance_scale=0.5, threads=None, progress=None)
/// --
///
/// Gives a map the levels of a mip pyramid, each half as wide and high as the one before.
/// output may be source. levels: at most so many, with level 0, else down to 1 × 1.
/// tolerance_scale: factor of the tolerance from level to level, in (0, 1].
///
/// Raises FileError, SettingError, Cancelled.
#[pyfunction]
#[pyo3(signature = (source, output, *, levels=None, tolerance_scale=0.5, threads=None,
                    progress=None))]
pub(crate) fn mip(
    py: Python<'_>,
    source: PathBuf,
    output: PathBuf,
    levels: Option<u32>,
    tolerance_scale: f32,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> Result<()> {
    if !(tolerance_scale > 0.0 && tolerance_scale <= 1.0) {
        return Err(crate::error::Failure::setting("tolerance_scale must lie in (0, 1]"));
    }
    let options = PyramidOptions::default().with_tolerance_scale(tolerance_scale);
    let options = levels.map_or(options, |levels| options.with_levels(levels.max(1)));
    run(py, threads, progress.as_ref(), |watch| {
        let map = MapReader::open(&source, &Limits::default())?;
        deepshadow::files::mip(&map, &output, &options, |at| watch.at(at))
    })?;
    Ok(())
}

/// merge(sources, output, *, tolerance=None, threads=None, progress=None)
/// --
///
/// Makes one map of several: crops of one map, which together cover it, are put together;
/// maps of the same pixels are multiplied, within the error bound tolerance on top of theirs
/// (0 keeps every step). Returns "crops" or "product".
///
/// Raises FileError, SettingError for maps that do not go together, Cancelled.
#[pyfunction]
#[pyo3(signature = (sources, output, *, tolerance=None, threads=None, progress=None))]
pub(crate) fn merge(
    py: Python<'_>,
    sources: Vec<PathBuf>,
    output: PathBuf,
    tolerance: Option<f32>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> Result<&'static str> {
    let tolerance = tolerance.map(Tolerance::new).transpose()?;
    let report = run(py, threads, progress.as_ref(), |watch| {
        let open = |path: &PathBuf| MapReader::open(path, &Limits::default());
        let maps = sources.iter().map(open).collect::<std::result::Result<Vec<_>, _>>()?;
        deepshadow::files::merge(&maps, &output, tolerance, |at| watch.at(at))
    })?;
    Ok(match report {
        MergeReport::Multiplied { .. } => "product",
        _ => "crops",
    })
}

/// diff(a, b, *, threads=None, progress=None)
/// --
///
/// How far the visibility functions of two maps or deep images are apart, over all pixels of
/// all levels that both have: a dict of max, the largest difference at any depth, mean, and
/// worst, the level, y, x, z and channel of the largest, or None. In [0, 1].
///
/// Raises FileError, SettingError for maps of different sizes, Cancelled.
#[pyfunction]
#[pyo3(signature = (a, b, *, threads=None, progress=None))]
pub(crate) fn diff<'py>(
    py: Python<'py>,
    a: PathBuf,
    b: PathBuf,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> Result<Bound<'py, PyDict>> {
    let difference: MapDifference = run(py, threads, progress.as_ref(), |watch| {
        let open = |path: &Path| MapSource::open(path, None, &Limits::default());
        compare_levels(&mut open(&a)?, &mut open(&b)?, |at| watch.at(at))
    })?;
    let worst = difference.worst.map(|worst| -> Result<_> {
        let dict = PyDict::new(py);
        dict.set_item("level", worst.level)?;
        dict.set_item("y", worst.y)?;
        dict.set_item("x", worst.x)?;
        dict.set_item("z", worst.z)?;
        dict.set_item("channel", worst.channel)?;
        Ok(dict)
    });
    let dict = PyDict::new(py);
    dict.set_item("max", difference.max())?;
    dict.set_item("mean", difference.mean)?;
    dict.set_item("worst", worst.transpose()?)?;
    Ok(dict)
}

/// verify(path, *, against=None, part=None, layer=None, channels=None, threads=None, progress=None)
/// --
///
/// Everything that is wrong with a map, a line each; empty if it is sound. against: the map
/// or deep image that it was made of; every function is held to the bound that the map states.
///
/// Raises FileError if the file is no map at all, or against cannot be read; Cancelled.
#[pyfunction]
#[pyo3(signature = (path, *, against=None, part=None, layer=None, channels=None, threads=None,
                    progress=None))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments")]
pub(crate) fn verify(
    py: Python<'_>,
    path: PathBuf,
    against: Option<PathBuf>,
    part: Option<String>,
    layer: Option<String>,
    channels: Option<&str>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> Result<Vec<String>> {
    let chosen = selection(part, layer, channels)?;
    run(py, threads, progress.as_ref(), |watch| -> Result<_, deepshadow::Error> {
        let map = ShadowMap::open(&path)?;
        let mut errors: Vec<_> = map.verify().iter().map(|error| whole_message(error)).collect();
        if let (Some(against), true) = (&against, errors.is_empty()) {
            let mut source = MapSource::open(against, chosen, &Limits::default())?;
            match map.check_against(&mut source, |at| watch.at(at)) {
                Err(deepshadow::Error::File(FileError::Interrupted)) => {
                    return Err(deepshadow::Error::Interrupted);
                }
                checked => errors.extend(checked.err().map(|error| whole_message(&error))),
            }
        }
        Ok(errors)
    })
}
