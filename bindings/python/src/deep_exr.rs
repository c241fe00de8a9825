//! Deep OpenEXR images as ragged columns.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use deepshadow::files::deep_exr::detail::Alpha;
use deepshadow::files::deep_exr::{
    AlphaChannels, Attribute as ImageAttribute, Compression, DeepExrReader, DeepExrWriter,
    DeepRows, Error as ImageError, Header, Limits as ImageLimits, SampleType, Selection, Window,
    WriteOptions,
};
use deepshadow::files::detail::{NdcRange, ViewAxis, replace_file};
use deepshadow::files::{Error as FileError, MapSource};
use numpy::{AllowTypeChange, PyArrayLike1, PyArrayLikeDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;

use crate::convert_options::{selection, take_map, take_storage};
use crate::deep_image::DeepImage;
use crate::error::{Failure, Result};
use crate::files::imported;
use crate::options::Options;
use crate::progress::run;
use crate::threads;
use crate::{arrays, attributes, camera};

/// Rows that one task reads at least.
const ROWS: u32 = 16;

/// read_deep_exr(path, *, part=None, layer=None, channels=None, threads=None)
/// --
///
/// Reads a deep image, or a flat one with a channel Z as one sample a pixel, into ragged
/// columns. part: its name, else the first deep one. layer: what stands before the last dot
/// of its channels' names. channels: such as "Z=depth,A=alpha".
///
/// Raises FileError with the file and the place in it. Cost: O(samples), on all cores.
#[pyfunction]
#[pyo3(signature = (path, *, part=None, layer=None, channels=None, threads=None))]
pub(crate) fn read_deep_exr(
    py: Python<'_>,
    path: PathBuf,
    part: Option<String>,
    layer: Option<String>,
    channels: Option<&str>,
    threads: Option<usize>,
) -> Result<DeepImage> {
    let chosen = selection(part, layer, channels)?;
    let pool = threads::pool(threads)?;
    let read = py.detach(|| pool.install(|| read(&path, &chosen)));
    let (header, rows) = read.map_err(|error| FileError::from(error).in_file(&*path))?;
    DeepImage::new(py, header, rows)
}

/// The rows of an image, on the threads of the current pool.
fn read(path: &Path, chosen: &Selection) -> Result<(Header, DeepRows), ImageError> {
    let limits = ImageLimits::default();
    let mut first = DeepExrReader::open(path, chosen.clone(), &limits)?;
    let header = first.header().clone();
    // Tiles are read whole: no task begins within one.
    let unit = match header.layout {
        deepshadow::files::deep_exr::Layout::Tiles { height, .. } => height.max(1),
        _ => 1,
    };
    let tasks = header.height.div_ceil(ROWS).min(rayon::current_num_threads() as u32).max(1);
    let rows = header.height.div_ceil(tasks).next_multiple_of(unit);
    if rows >= header.height {
        return Ok((header.clone(), first.read_rows(0..header.height)?));
    }
    let starts: Vec<u32> = (0..header.height).step_by(rows as usize).collect();
    let bands = starts.into_par_iter().map(|start| {
        let mut reader = DeepExrReader::open(path, chosen.clone(), &limits)?;
        reader.read_rows(start..header.height.min(start.saturating_add(rows)))
    });
    let bands = bands.collect::<std::result::Result<Vec<_>, _>>()?;
    let rows = together(header.width, bands)?;
    Ok((header, rows))
}

/// Bands of rows as one.
fn together(width: u32, bands: Vec<DeepRows>) -> Result<DeepRows, ImageError> {
    let count: usize = bands.iter().map(DeepRows::sample_count).sum();
    if u32::try_from(count).is_err() {
        return Err(ImageError::LimitExceeded {
            place: "image".to_owned(),
            what: "number of samples in one answer",
            value: count as u64,
            limit: u32::MAX.into(),
        });
    }
    let mut bands = bands.into_iter();
    let Some(first) = bands.next() else {
        return DeepRows::from_columns(width, vec![0], Vec::new(), None, Alpha::Opaque);
    };
    let (mut offsets, mut z, mut back, mut alpha) = first.into_columns();
    z.reserve_exact(count - z.len());
    for band in bands {
        let (more, more_z, more_back, more_alpha) = band.into_columns();
        let start = z.len() as u32;
        offsets.extend(more[1..].iter().map(|offset| start + offset));
        z.extend(more_z);
        if let (Some(back), Some(more)) = (&mut back, more_back) {
            back.extend(more);
        }
        match (&mut alpha, more_alpha) {
            (Alpha::Mono(alpha), Alpha::Mono(more)) => alpha.extend(more),
            (Alpha::Colour(all), Alpha::Colour(more)) => {
                all.iter_mut().zip(more).for_each(|(all, more)| all.extend(more));
            }
            _ => {}
        }
    }
    DeepRows::from_columns(width, offsets, z, back, alpha)
}

/// The columns of arrays.
fn columns(
    [rows, columns]: [u32; 2],
    offsets: &Bound<'_, PyAny>,
    z: PyArrayLike1<'_, f32, AllowTypeChange>,
    alpha: Option<&Bound<'_, PyAny>>,
    back: Option<PyArrayLike1<'_, f32, AllowTypeChange>>,
) -> Result<DeepRows> {
    let offsets = arrays::indices(offsets, "offsets")?;
    let pixels = u64::from(rows) * u64::from(columns);
    if offsets.len() as u64 != pixels + 1 {
        let count = offsets.len();
        let reason =
            format!("{count} offsets for {pixels} pixels: one more than pixels are needed");
        return Err(Failure::setting(reason));
    }
    let z = z.as_array().to_vec();
    let alpha = match alpha.filter(|alpha| !alpha.is_none()) {
        None => Alpha::Opaque,
        Some(alpha) => opacities(alpha)?,
    };
    let back = back.map(|back| back.as_array().to_vec());
    Ok(DeepRows::from_columns(columns, offsets, z, back, alpha)?)
}

fn opacities(given: &Bound<'_, PyAny>) -> Result<Alpha> {
    let array: PyArrayLikeDyn<'_, f32, AllowTypeChange> = given.extract()?;
    let view = array.as_array();
    match *array.shape() {
        [_] => Ok(Alpha::Mono(view.iter().copied().collect())),
        [count, 3] => {
            Ok(Alpha::Colour([0, 1, 2].map(|c| (0..count).map(|i| view[[i, c]]).collect())))
        }
        ref shape => {
            let reason = format!("a: one opacity a sample, or (samples, 3), not {shape:?}");
            Err(Failure::setting(reason))
        }
    }
}

/// The header of an image with these columns.
fn image(
    rows: &DeepRows,
    corner: [i32; 2],
    attrs: Option<&Bound<'_, PyAny>>,
    known: Option<&Bound<'_, PyAny>>,
    sample_type: SampleType,
) -> Result<WriteOptions> {
    let mut options = WriteOptions::new(rows.width(), rows.rows())
        .corner(corner)
        .alpha(rows.alpha_channels(), sample_type)
        .z_back(rows.z_back().is_some());
    for (name, attribute) in &attributes::from_dict(attrs)? {
        options.set(attributes::for_image(name, attribute))?;
    }
    if let Some(known) = known {
        let known = camera::from_dict(known)?;
        for (name, matrix) in
            [("worldToCamera", known.world_to_camera), ("worldToNDC", known.world_to_ndc)]
        {
            let Some(matrix) = matrix else { continue };
            let numbers = matrix.to_cols_array().map(|number| number as f32);
            options.set(ImageAttribute::floats(name, "m44f", &numbers))?;
        }
    }
    Ok(options)
}

fn encode(rows: &DeepRows, options: &WriteOptions) -> Result<Vec<u8>, ImageError> {
    let mut writer = DeepExrWriter::new(Cursor::new(Vec::new()), options)?;
    writer.write_rows(rows)?;
    Ok(writer.finish()?.into_inner())
}

/// write_deep_exr(path, offsets, z, a=None, zback=None, *, shape, corner=(0, 0),
///                display_window=None, camera=None, attrs=None, **storage)
/// --
///
/// Writes ragged columns as a deep OpenEXR, which replaces path when it is whole.
///
/// offsets: (pixels + 1,), z: (samples,), a: (samples,) or (samples, 3), or None for an image
/// without opacities, zback: (samples,) or None. shape: (rows, columns). corner: the first
/// pixel. display_window: left, top, right, bottom, inclusive. camera: a dict of world_to_camera
/// and world_to_ndc, (4, 4) for column vectors, kept as float32. attrs: a dict of str, int,
/// float, lists of 2, 3, 9 or 16 floats, or (OpenEXR type, value or bytes).
///
/// storage: compression ("zips", "rle", "zstd", "none"), type of opacities ("float", "half"),
/// layout ("scanline", "tiled"), tile (64).
///
/// Raises SettingError for columns that do not fit together, FileError if it cannot be written.
#[pyfunction]
#[pyo3(signature = (path, offsets, z, a=None, zback=None, *, shape, corner=[0, 0],
                    display_window=None, camera=None, attrs=None, **storage))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments")]
pub(crate) fn write_deep_exr<'py>(
    py: Python<'py>,
    path: PathBuf,
    offsets: &Bound<'py, PyAny>,
    z: PyArrayLike1<'py, f32, AllowTypeChange>,
    a: Option<&Bound<'py, PyAny>>,
    zback: Option<PyArrayLike1<'py, f32, AllowTypeChange>>,
    shape: [u32; 2],
    corner: [i32; 2],
    display_window: Option<[i32; 4]>,
    camera: Option<&Bound<'py, PyAny>>,
    attrs: Option<&Bound<'py, PyAny>>,
    storage: Option<&Bound<'py, PyDict>>,
) -> Result<()> {
    let given = Options::new(py, storage)?;
    let (layout, compression, sample_type) =
        take_storage(&given, ["layout", "compression", "type"])?;
    given.finish("write_deep_exr")?;
    let rows = columns(shape, offsets, z, a, zback)?;
    let mut options =
        image(&rows, corner, attrs, camera, sample_type)?.layout(layout).compression(compression);
    if let Some([left, top, right, bottom]) = display_window {
        options = options.display_window(Window { min: [left, top], max: [right, bottom] });
    }
    py.detach(|| -> Result<()> { Ok(replace_file(&path, &encode(&rows, &options)?)?) })
}

/// from_deep(offsets, z, a, zback=None, *, shape, output, camera=None, attrs=None,
///           threads=None, progress=None, **settings)
/// --
///
/// Makes a map, the file output (.dsm), of a deep image's ragged columns: samples become
/// visibility functions, as convert() makes them of a deep OpenEXR. Returns convert()'s dict.
///
/// The columns are those of write_deep_exr(). camera: a dict such as Map.camera, kept as
/// float32. settings: tolerance in [0, 1) (0), method, side, codec, depth_error, block, tile, as bake() has
/// them. Cost: O(samples · log samples of a pixel).
///
/// Raises SettingError for columns that do not fit together, Cancelled.
#[pyfunction]
#[pyo3(signature = (offsets, z, a, zback=None, *, shape, output, camera=None, attrs=None,
                    threads=None, progress=None, **settings))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments")]
pub(crate) fn from_deep<'py>(
    py: Python<'py>,
    offsets: &Bound<'py, PyAny>,
    z: PyArrayLike1<'py, f32, AllowTypeChange>,
    a: Option<&Bound<'py, PyAny>>,
    zback: Option<PyArrayLike1<'py, f32, AllowTypeChange>>,
    shape: [u32; 2],
    output: PathBuf,
    camera: Option<&Bound<'py, PyAny>>,
    attrs: Option<&Bound<'py, PyAny>>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
    settings: Option<&Bound<'py, PyDict>>,
) -> Result<Bound<'py, PyDict>> {
    let given = Options::new(py, settings)?;
    let mut options = take_map(&given)?;
    given.finish("from_deep")?;
    // The matrices are a map's own.
    options.cameras.view_axis = Some(ViewAxis::MinusZ);
    options.cameras.ndc_range = Some(NdcRange::Unit);
    let rows = columns(shape, offsets, z, a, zback)?;
    let image = image(&rows, [0, 0], attrs, camera, SampleType::Float)?;
    let image = image.compression(Compression::None);
    let is_opaque = rows.alpha_channels() == AlphaChannels::None;
    let report = run(py, threads, progress.as_ref(), |watch| -> Result<_> {
        let bytes = encode(&rows, &image)?;
        let reader = DeepExrReader::from_bytes(bytes, None, &ImageLimits::default())?;
        let mut source = MapSource::Image(Box::new(reader));
        Ok(deepshadow::files::convert(&mut source, &output, &options, |at| watch.at(at))?)
    })?;
    let dict = imported(py, &report)?;
    dict.set_item("opaque", is_opaque)?;
    Ok(dict)
}
