//! Queries.

use std::ffi::c_char;

use deepshadow::glam::DVec3;
use deepshadow::{Shadow, Values};

use super::guard::{guard, guarded};
use super::map::ds_map;
use super::pointers::{borrow, hand_out, release, retain, slice, slice_mut, text, write};
use crate::failure::{Failure, Result, ds_status};
use crate::settings::{ds_light, ds_query};

/// The shadows of a query, ready for any number of points, from any thread.
#[expect(non_camel_case_types, reason = "a name of C")]
pub struct ds_shadow {
    shadow: Shadow,
    has_camera: bool,
}

/// Gives every field of a query its default.
///
/// # Safety
///
/// `query` can be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_query_init(query: *mut ds_query) {
    // SAFETY: the header asks for a pointer that can be written to.
    guard(|| unsafe { write(query, ds_query::default(), "query") });
}

/// Gives every field of a light its default: a point one unit above the origin, of 45 degrees.
///
/// # Safety
///
/// `light` can be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_light_init(light: *mut ds_light) {
    // SAFETY: the header asks for a pointer that can be written to.
    guard(|| unsafe { write(light, ds_light::default(), "light") });
}

/// Makes the shadows of a query ready. `query` may be NULL: all defaults.
///
/// # Safety
///
/// `map` is a map that was not released, `query` NULL or a query whose pointers are NULL or
/// strings, and `out` can be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_map_shadow(
    map: *const ds_map,
    query: *const ds_query,
    out: *mut *const ds_shadow,
) -> ds_status {
    guard(|| {
        // SAFETY: the header asks for a handle that was not released.
        let map = &unsafe { borrow(map, "map") }?.map;
        let given = if query.is_null() {
            ds_query::default()
        } else {
            // SAFETY: the header asks for a query.
            *unsafe { borrow(query, "query") }?
        };
        // SAFETY: the header asks for strings.
        let words = unsafe {
            let method: *const c_char = given.method;
            (text(method, "method")?, text(given.filter, "filter")?)
        };
        let query = given.query(words.0, words.1, map.default_method())?;
        let shadow = map.shadow(&query)?;
        let has_camera = map.info().camera.is_some();
        // SAFETY: the header asks for an `out` that can be written to.
        unsafe { hand_out(out, ds_shadow { shadow, has_camera }) }
    })
}

/// Adds a reference, and returns the shadows.
///
/// # Safety
///
/// `shadow` is NULL or shadows that were not released.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_shadow_retain(shadow: *const ds_shadow) -> *const ds_shadow {
    // SAFETY: the header asks for a handle that was not released.
    unsafe { retain(shadow) }
}

/// Takes a reference off; the last one frees the shadows.
///
/// # Safety
///
/// `shadow` is NULL or shadows that were not released.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_shadow_release(shadow: *const ds_shadow) {
    // SAFETY: the header asks for a handle that was not released.
    unsafe { release(shadow) }
}

/// Numbers a point: 1 or 3; 0 for NULL.
///
/// # Safety
///
/// `shadow` is NULL or shadows that were not released.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_shadow_channels(shadow: *const ds_shadow) -> u32 {
    guarded(0, || {
        // SAFETY: the header asks for a handle that was not released.
        unsafe { shadow.as_ref() }.map_or(0, |shadow| shadow.shadow.channels() as u32)
    })
}

/// The shadow factors of points of the world, 1 lit and 0 dark, on all cores: `points` has x, y
/// and z of each, `values` room for as many numbers as ds_shadow_channels says of each. `first`
/// is the number of the first point where these are part of a longer list, else 0.
///
/// # Safety
///
/// `shadow` are shadows that were not released; the arrays are as long as said.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_shadow_world(
    shadow: *const ds_shadow,
    points: *const f64,
    count: usize,
    first: u64,
    values: *mut f32,
) -> ds_status {
    guard(|| {
        // SAFETY: the header asks for a handle and arrays of these lengths.
        let (shadow, points, values) = unsafe { arrays(shadow, points, count, values) }?;
        if !shadow.has_camera {
            let reason = "the map has no camera to project points of the world with";
            return Err(Failure::setting(reason));
        }
        let points: Vec<_> = points.iter().copied().map(DVec3::from).collect();
        copy(&shadow.shadow.query_from(&points, first)?, values)
    })
}

/// The same of raster positions: column and row in pixels of level 0, and the depth.
///
/// # Safety
///
/// As of ds_shadow_world.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_shadow_raster(
    shadow: *const ds_shadow,
    points: *const f64,
    count: usize,
    first: u64,
    values: *mut f32,
) -> ds_status {
    guard(|| {
        // SAFETY: the header asks for a handle and arrays of these lengths.
        let (shadow, points, values) = unsafe { arrays(shadow, points, count, values) }?;
        copy(&shadow.shadow.query_raster(points, first)?, values)
    })
}

/// The shadows, points and room for values of a call.
type Arrays<'a> = (&'a ds_shadow, &'a [[f64; 3]], &'a mut [f32]);

/// # Safety
///
/// As of [`ds_shadow_world`].
unsafe fn arrays<'a>(
    shadow: *const ds_shadow,
    points: *const f64,
    count: usize,
    values: *mut f32,
) -> Result<Arrays<'a>> {
    // SAFETY: as promised to this function.
    let shadow = unsafe { borrow(shadow, "shadow") }?;
    let channels = shadow.shadow.channels();
    let numbers = count.saturating_mul(channels);
    // SAFETY: as promised to this function.
    Ok(unsafe {
        (shadow, slice(points.cast(), count, "points")?, slice_mut(values, numbers, "values")?)
    })
}

fn copy(values: &Values, out: &mut [f32]) -> Result<()> {
    for (point, out) in out.chunks_exact_mut(values.channels()).enumerate() {
        out.copy_from_slice(&values.rgb(point)[..values.channels()]);
    }
    Ok(())
}
