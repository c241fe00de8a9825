//! Deep OpenEXR images.

use std::ffi::c_char;
use std::io::Cursor;
use std::path::Path;

use deepshadow::files::deep_exr::detail::Alpha;
use deepshadow::files::deep_exr::{
    AlphaChannels, DeepExrReader, DeepExrWriter, DeepRows, Limits as ImageLimits, SampleType,
    WriteOptions,
};
use deepshadow::files::detail::replace_file;
use deepshadow::files::{
    ConvertOptions, Error as FileError, ExportOptions, Limits, MapSource, Packing,
    WriteOptions as MapOptions, export_deep_exr,
};
use deepshadow::visibility::{Progress, Tolerance};

use super::guard::guard;
use super::pointers::{borrow, hand_out, path, release, retain, slice, write};
use crate::failure::{Failure, Result, ds_status};

/// A deep image in memory.
#[expect(non_camel_case_types, reason = "a name of C")]
pub struct ds_deep {
    width: u32,
    height: u32,
    offsets: Vec<u32>,
    z: Vec<f32>,
    back: Option<Vec<f32>>,
    /// As many opacities a sample as there are colours.
    alpha: Option<Vec<f32>>,
    channels: u32,
}

/// A deep image in columns: the samples of pixel i, counted row by row, are offsets[i] to
/// offsets[i + 1].
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ds_deep_view {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Opacities a sample: 0, 1 or 3.
    pub channels: u32,
    /// Number of samples.
    pub samples: usize,
    /// First sample of each pixel, and the end: width * height + 1.
    pub offsets: *const u32,
    /// Front depths.
    pub z: *const f32,
    /// Back depths; NULL: there are none.
    pub zback: *const f32,
    /// Opacities; NULL: all samples are opaque.
    pub a: *const f32,
}

/// Reads a deep image, or a flat one with a depth as one sample a pixel.
///
/// # Safety
///
/// `file` is a string, and `out` can be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_deep_read(file: *const c_char, out: *mut *const ds_deep) -> ds_status {
    guard(|| {
        // SAFETY: the header asks for a string.
        let file = unsafe { path(file, "file") }?;
        let read = || {
            let mut reader = DeepExrReader::open(&file, None, &ImageLimits::default())?;
            let height = reader.header().height;
            reader.read_rows(0..height)
        };
        let rows = read().map_err(|error| FileError::from(error).in_file(&*file))?;
        // SAFETY: the header asks for an `out` that can be written to.
        unsafe { hand_out(out, image(rows)) }
    })
}

fn image(rows: DeepRows) -> ds_deep {
    let (width, height) = (rows.width(), rows.rows());
    let (offsets, z, back, alpha) = rows.into_columns();
    let (alpha, channels) = match alpha {
        Alpha::Opaque => (None, 0),
        Alpha::Mono(alpha) => (Some(alpha), 1),
        Alpha::Colour([red, green, blue]) => {
            let colours = red.iter().zip(&green).zip(&blue);
            let flat = colours.flat_map(|((&red, &green), &blue)| [red, green, blue]).collect();
            (Some(flat), 3)
        }
    };
    ds_deep { width, height, offsets, z, back, alpha, channels }
}

/// The columns of an image, which live as long as it.
///
/// # Safety
///
/// `deep` is an image that was not released, and `out` can be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_deep_describe(
    deep: *const ds_deep,
    out: *mut ds_deep_view,
) -> ds_status {
    guard(|| {
        // SAFETY: the header asks for a handle that was not released.
        let deep = unsafe { borrow(deep, "deep") }?;
        let pointer = |column: &Option<Vec<f32>>| {
            column.as_ref().map_or(std::ptr::null(), |column| column.as_ptr())
        };
        let view = ds_deep_view {
            width: deep.width,
            height: deep.height,
            channels: deep.channels,
            samples: deep.z.len(),
            offsets: deep.offsets.as_ptr(),
            z: deep.z.as_ptr(),
            zback: pointer(&deep.back),
            a: pointer(&deep.alpha),
        };
        // SAFETY: the header asks for an `out` that can be written to.
        unsafe { write(out, view, "out") }
    })
}

/// Adds a reference, and returns the image.
///
/// # Safety
///
/// `deep` is NULL or an image that was not released.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_deep_retain(deep: *const ds_deep) -> *const ds_deep {
    // SAFETY: the header asks for a handle that was not released.
    unsafe { retain(deep) }
}

/// Takes a reference off; the last one frees the image.
///
/// # Safety
///
/// `deep` is NULL or an image that was not released.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_deep_release(deep: *const ds_deep) {
    // SAFETY: the header asks for a handle that was not released.
    unsafe { release(deep) }
}

/// Writes columns as a deep image in scan lines, which replaces `file` when it is whole.
///
/// # Safety
///
/// `file` is a string, and the columns of `view` are as long as it says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_deep_write(
    file: *const c_char,
    view: *const ds_deep_view,
) -> ds_status {
    guard(|| {
        // SAFETY: the header asks for a string.
        let file = unsafe { path(file, "file") }?;
        // SAFETY: the header asks for columns of these lengths.
        let rows = unsafe { read_view(view) }?;
        let options = WriteOptions::new(rows.width(), rows.rows())
            .alpha(rows.alpha_channels(), SampleType::Float)
            .z_back(rows.z_back().is_some());
        let mut writer = DeepExrWriter::new(Cursor::new(Vec::new()), &options)?;
        writer.write_rows(&rows)?;
        Ok(replace_file(&file, writer.finish()?.get_ref())?)
    })
}

/// # Safety
///
/// `view` is NULL, or has columns that are as long as it says.
unsafe fn read_view(view: *const ds_deep_view) -> Result<DeepRows> {
    // SAFETY: as promised to this function.
    let view = unsafe { borrow(view, "view") }?;
    let pixels = (view.width as usize).checked_mul(view.height as usize);
    let Some(entries) = pixels.and_then(|pixels| pixels.checked_add(1)) else {
        return Err(Failure::setting("too many pixels"));
    };
    // SAFETY: as promised to this function.
    let (offsets, z) =
        unsafe { (slice(view.offsets, entries, "offsets")?, slice(view.z, view.samples, "z")?) };
    let back = if view.zback.is_null() {
        None
    } else {
        // SAFETY: as promised to this function.
        Some(unsafe { slice(view.zback, view.samples, "zback") }?.to_vec())
    };
    let alpha = match view.channels {
        0 => AlphaChannels::None,
        1 => AlphaChannels::Mono,
        3 => AlphaChannels::Colour,
        other => return Err(Failure::setting(format!("{other} opacities a sample"))),
    };
    let numbers = view.samples.saturating_mul(view.channels as usize);
    // SAFETY: as promised to this function.
    let given = unsafe { slice(view.a, numbers, "a") }?;
    let alpha = match alpha {
        AlphaChannels::None => Alpha::Opaque,
        AlphaChannels::Mono => Alpha::Mono(given.to_vec()),
        AlphaChannels::Colour => {
            let (colours, _) = given.as_chunks::<3>();
            Alpha::Colour([0, 1, 2].map(|at| colours.iter().map(|colour| colour[at]).collect()))
        }
    };
    Ok(DeepRows::from_columns(view.width, offsets.to_vec(), z.to_vec(), back, alpha)?)
}

/// Makes a map or an image of a file.
pub(super) fn convert(source: &Path, output: &Path, tolerance: f32) -> Result<()> {
    let tolerance = (!tolerance.is_nan()).then(|| Tolerance::new(tolerance)).transpose()?;
    let mut source = MapSource::open(source, None, &Limits::default())?;
    if output.extension().is_some_and(|end| end.eq_ignore_ascii_case("exr")) {
        let defaults = ExportOptions::default();
        let options = ExportOptions { error: tolerance.unwrap_or(defaults.error), ..defaults };
        export_deep_exr(&mut source, output, &options, Progress::ignore)?;
    } else {
        let write = MapOptions::default().with_packing(Packing::Zstd);
        let tolerance = tolerance.unwrap_or_default();
        let options = ConvertOptions { tolerance, write, ..ConvertOptions::default() };
        deepshadow::files::convert(&mut source, output, &options, Progress::ignore)?;
    }
    Ok(())
}
