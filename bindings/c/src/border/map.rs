//! Maps: opened, described, and their columns.

use std::ffi::{CString, c_char};

use deepshadow::files::detail::{AnyDeepMap, TileRect};
use deepshadow::visibility::{DeepMap, Transmittance};
use deepshadow::{OpenOptions, ShadowMap};

use super::cache::ds_cache;
use super::guard::{guard, guarded};
use super::pointers::{borrow, hand_out, path, release, retain, write};
use crate::failure::{Failure, Result, ds_status};

/// An open map. Any number of threads may use it.
#[expect(non_camel_case_types, reason = "a name of C")]
pub struct ds_map {
    pub(super) map: ShadowMap,
    kind: CString,
}

/// What a map is.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct ds_map_info {
    /// Width of level 0 in pixels.
    pub width: u32,
    /// Height of level 0 in pixels.
    pub height: u32,
    /// Numbers a value: 1 or 3.
    pub channels: u32,
    /// Number of levels.
    pub levels: u32,
    /// Not 0: it has a camera, and answers points of the world.
    pub has_camera: i32,
}

/// The visibility functions of a level, in columns.
#[expect(non_camel_case_types, reason = "a name of C")]
pub struct ds_columns {
    offsets: Vec<u32>,
    depths: Vec<f32>,
    values: Vec<f32>,
}

/// The columns of a level: the vertices of pixel i, counted row by row, are offsets[i] to
/// offsets[i + 1]. They live as long as their handle.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ds_column_view {
    /// Number of pixels; there is one offset more.
    pub pixels: usize,
    /// Number of vertices.
    pub vertices: usize,
    /// First vertex of each pixel, and the end.
    pub offsets: *const u32,
    /// Depths in scene units, ascending in each pixel.
    pub depths: *const f32,
    /// Values in [0, 1]: one a vertex, of RGB maps three.
    pub values: *const f32,
}

/// Opens a map of any kind. `cache` may be NULL: then it has one of its own.
///
/// # Safety
///
/// `file` is a string, `cache` NULL or a cache, and `out` can be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_map_open(
    file: *const c_char,
    cache: *const ds_cache,
    out: *mut *const ds_map,
) -> ds_status {
    guard(|| {
        // SAFETY: the header asks for a string.
        let file = unsafe { path(file, "file") }?;
        let options = if cache.is_null() {
            OpenOptions::new()
        } else {
            // SAFETY: the header asks for a cache that was not released.
            unsafe { borrow(cache, "cache") }?.0.clone()
        };
        let map = options.open(file)?;
        let kind = CString::new(map.kind()).unwrap_or_default();
        // SAFETY: the header asks for an `out` that can be written to.
        unsafe { hand_out(out, ds_map { map, kind }) }
    })
}

/// Adds a reference, and returns the map.
///
/// # Safety
///
/// `map` is NULL or a map that was not released.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_map_retain(map: *const ds_map) -> *const ds_map {
    // SAFETY: the header asks for a handle that was not released.
    unsafe { retain(map) }
}

/// Takes a reference off; the last one closes the map.
///
/// # Safety
///
/// `map` is NULL or a map that was not released.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_map_release(map: *const ds_map) {
    // SAFETY: the header asks for a handle that was not released.
    unsafe { release(map) }
}

/// The name of the map's kind, which lives as long as the map; NULL for NULL.
///
/// # Safety
///
/// `map` is NULL or a map that was not released.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_map_kind(map: *const ds_map) -> *const c_char {
    guarded(std::ptr::null(), || {
        // SAFETY: the header asks for a handle that was not released.
        unsafe { map.as_ref() }.map_or(std::ptr::null(), |map| map.kind.as_ptr())
    })
}

/// What a map is.
///
/// # Safety
///
/// `map` is a map that was not released, and `out` can be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_map_describe(map: *const ds_map, out: *mut ds_map_info) -> ds_status {
    guard(|| {
        // SAFETY: the header asks for a handle that was not released.
        let map = &unsafe { borrow(map, "map") }?.map;
        let [width, height] = map.size();
        let info = ds_map_info {
            width,
            height,
            channels: map.channels() as u32,
            levels: map.levels().len() as u32,
            has_camera: map.info().camera.is_some().into(),
        };
        // SAFETY: the header asks for an `out` that can be written to.
        unsafe { write(out, info, "out") }
    })
}

/// Everything that is wrong with a map's file: how many errors there are. The first one is the
/// message of ds_error_message.
///
/// # Safety
///
/// `map` is a map that was not released, and `errors` can be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_map_verify(map: *const ds_map, errors: *mut usize) -> ds_status {
    guard(|| {
        // SAFETY: the header asks for a handle that was not released.
        let found = unsafe { borrow(map, "map") }?.map.verify();
        // SAFETY: the header asks for a pointer that can be written to.
        unsafe { write(errors, found.len(), "errors") }?;
        if let Some(first) = found.into_iter().next() {
            Failure::from(first).keep();
        }
        Ok(())
    })
}

/// Reads the visibility functions of a level.
///
/// # Safety
///
/// `map` is a map that was not released, and `out` can be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_map_columns(
    map: *const ds_map,
    level: u32,
    out: *mut *const ds_columns,
) -> ds_status {
    guard(|| {
        // SAFETY: the header asks for a handle that was not released.
        let map = &unsafe { borrow(map, "map") }?.map;
        let Some(found) = map.levels().get(level as usize) else {
            let count = map.levels().len();
            return Err(Failure::setting(format!("level {level}: the map has {count}")));
        };
        let rect = TileRect { x: 0, y: 0, width: found.width, height: found.height };
        let columns = match map.functions(level, rect)? {
            Some(AnyDeepMap::Mono(map)) => columns(&map),
            Some(AnyDeepMap::Rgb(map)) => columns(&map),
            None => {
                let reason = format!("a map of kind {} has no visibility functions", map.kind());
                let path = map.container().path().unwrap_or("".as_ref()).to_owned();
                return Err(deepshadow::Error::Query { path, reason }.into());
            }
        };
        // SAFETY: the header asks for an `out` that can be written to.
        unsafe { hand_out(out, columns) }
    })
}

fn columns<T: Transmittance>(map: &DeepMap<T>) -> ds_columns {
    let view = map.pixels().view();
    let values = view.functions().flat_map(|function| {
        let vertices: Vec<_> = function.vertices().collect();
        vertices
            .into_iter()
            .flat_map(|vertex| (0..T::CHANNELS).map(move |c| vertex.value.channel(c)))
    });
    let values = values.collect();
    ds_columns { offsets: view.starts().to_vec(), depths: view.depths().to_vec(), values }
}

/// The columns of a level. They live as long as `columns`.
///
/// # Safety
///
/// `columns` are columns that were not released, and `out` can be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_columns_view(
    columns: *const ds_columns,
    out: *mut ds_column_view,
) -> ds_status {
    guard(|| {
        // SAFETY: the header asks for a handle that was not released.
        let columns = unsafe { borrow(columns, "columns") }?;
        let view = ds_column_view {
            pixels: columns.offsets.len() - 1,
            vertices: columns.depths.len(),
            offsets: columns.offsets.as_ptr(),
            depths: columns.depths.as_ptr(),
            values: columns.values.as_ptr(),
        };
        // SAFETY: the header asks for an `out` that can be written to.
        unsafe { write(out, view, "out") }
    })
}

/// Adds a reference, and returns the columns.
///
/// # Safety
///
/// `columns` is NULL or columns that were not released.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_columns_retain(columns: *const ds_columns) -> *const ds_columns {
    // SAFETY: the header asks for a handle that was not released.
    unsafe { retain(columns) }
}

/// Takes a reference off; the last one frees the columns.
///
/// # Safety
///
/// `columns` is NULL or columns that were not released.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_columns_release(columns: *const ds_columns) {
    // SAFETY: the header asks for a handle that was not released.
    unsafe { release(columns) }
}

/// Makes a map of a deep image or another map, or if `output` ends in .exr a deep image of a
/// map. `tolerance`: the bound of the error that this may add, NaN: what is usual.
///
/// # Safety
///
/// `source` and `output` are strings.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_convert(
    source: *const c_char,
    output: *const c_char,
    tolerance: f32,
) -> ds_status {
    guard(|| -> Result<()> {
        // SAFETY: the header asks for strings.
        let (source, output) = unsafe { (path(source, "source")?, path(output, "output")?) };
        super::deep::convert(&source, &output, tolerance)
    })
}
