//! Bakes.

use std::ffi::{c_char, c_void};
use std::ops::ControlFlow;
use std::path::Path;

use deepshadow::scene::{Light, open_scene};
use deepshadow::visibility::{Progress, TileSamples};
use deepshadow::{Bake, BakeReport, Channels, Occluders, bake};

use super::guard::guard;
use super::pointers::{borrow, borrow_mut, path, slice, slice_mut, text, write};
use crate::failure::{Failure, Result, ds_status};
use crate::hit_source::{CallerOccluders, ds_hits, ds_view};
use crate::settings::{ds_bake, ds_light, ds_progress, ds_report};

/// The sample points of a block of pixels: columns of `count` entries, which live as long as the
/// call that they are handed to.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ds_tile {
    /// Number of sample points.
    pub count: usize,
    /// Columns in pixels, from the left edge of the map.
    pub x: *const f64,
    /// Rows in pixels, from the top edge of the map.
    pub y: *const f64,
    /// Times in [0, 1].
    pub time: *const f32,
    /// What they are seen through, for ds_view_rays.
    pub view: *const ds_view,
}

/// Adds the hits of the sample points of `tile` to `hits`, in any order; called from any thread.
/// Anything but 0 ends the bake.
#[expect(non_camel_case_types, reason = "a name of C")]
pub type ds_hit_function = Option<
    unsafe extern "C" fn(user: *mut c_void, tile: *const ds_tile, hits: *mut ds_hits) -> i32,
>;

/// A pointer of the caller's, who promises that any thread may use it.
#[derive(Clone, Copy)]
struct User(*mut c_void);

// SAFETY: the header says that functions are called from any thread with it.
unsafe impl Send for User {}
// SAFETY: as above.
unsafe impl Sync for User {}

impl User {
    const fn get(self) -> *mut c_void {
        self.0
    }
}

/// Gives every field of a bake its default.
///
/// # Safety
///
/// `settings` can be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_bake_init(settings: *mut ds_bake) {
    // SAFETY: the header asks for a pointer that can be written to.
    guard(|| unsafe { write(settings, ds_bake::default(), "settings") });
}

/// Bakes a scene: a scene file, a model, or "builtin:NAME". `light` may be NULL: the scene's.
/// `settings` and `report` may be NULL. `output` is replaced when the map is whole.
///
/// # Safety
///
/// `scene` and `output` are strings, `light` and `settings` NULL or such, and `report` NULL or
/// can be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_bake_scene(
    scene: *const c_char,
    light: *const ds_light,
    settings: *const ds_bake,
    output: *const c_char,
    report: *mut ds_report,
) -> ds_status {
    guard(|| {
        // SAFETY: the header asks for strings.
        let (scene, output) = unsafe { (path(scene, "scene")?, path(output, "output")?) };
        // SAFETY: the header asks for settings or NULL.
        let asked = unsafe { Asked::read(settings) }?;
        let scene = open_scene(&scene)?;
        let own = if light.is_null() {
            scene.light
        } else {
            // SAFETY: the header asks for a light.
            unsafe { borrow(light, "light") }?.light()?
        };
        let mut asked = asked;
        if !asked.is_sized {
            asked.settings.resolution = asked.settings.kind.resolution_for(&scene);
        }
        // SAFETY: the header asks for NULL or a pointer that can be written to.
        unsafe { tell(&asked.run(&scene, &own, &output)?, report) }
    })
}

/// Bakes the hits of a function. `light` says from where; `media` is not 0 if it adds slabs.
/// `user` is handed to the function, which is called from any thread.
///
/// # Safety
///
/// `function` may be called from any thread with `user`; `light` is a light, `settings` NULL or
/// settings, `output` a string, and `report` NULL or can be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_bake_hits(
    function: ds_hit_function,
    user: *mut c_void,
    media: i32,
    light: *const ds_light,
    settings: *const ds_bake,
    output: *const c_char,
    report: *mut ds_report,
) -> ds_status {
    guard(|| {
        let Some(function) = function else { return Err(Failure::setting("function: NULL")) };
        // SAFETY: the header asks for a string.
        let output = unsafe { path(output, "output") }?;
        // SAFETY: the header asks for a light.
        let light = unsafe { borrow(light, "light") }?.light()?;
        // SAFETY: the header asks for settings or NULL.
        let asked = unsafe { Asked::read(settings) }?;
        let user = User(user);
        let answer = move |samples: &TileSamples, view: &ds_view, hits: &mut ds_hits| {
            let tile = ds_tile {
                count: samples.x().len(),
                x: samples.x().as_ptr(),
                y: samples.y().as_ptr(),
                time: samples.times().as_ptr(),
                view,
            };
            // SAFETY: all pointers are good for the call; the header says that the function may
            // be called from any thread.
            unsafe { function(user.get(), &raw const tile, hits) }
        };
        let is_coloured = asked.settings.channels == Channels::Rgb;
        let occluders = CallerOccluders { answer, is_coloured, has_media: media != 0 };
        // SAFETY: the header asks for NULL or a pointer that can be written to.
        unsafe { tell(&asked.run(&occluders, &light, &output)?, report) }
    })
}

/// Settings, and who is told of the work.
struct Asked {
    settings: Bake,
    is_sized: bool,
    progress: ds_progress,
    user: User,
}

impl Asked {
    /// # Safety
    ///
    /// `settings` is NULL, or settings whose pointers are NULL or strings.
    unsafe fn read(settings: *const ds_bake) -> Result<Self> {
        let given = if settings.is_null() {
            ds_bake::default()
        } else {
            // SAFETY: as promised to this function.
            *unsafe { borrow(settings, "settings") }?
        };
        // SAFETY: as promised to this function.
        let kind = unsafe { text(given.kind, "kind") }?;
        let (settings, is_sized) = given.settings(kind)?;
        Ok(Self { settings, is_sized, progress: given.progress, user: User(given.user) })
    }

    fn run(&self, occluders: &dyn Occluders, light: &Light, output: &Path) -> Result<BakeReport> {
        let (progress, user) = (self.progress, self.user);
        let watch = |at: Progress| match progress {
            Some(progress) if progress(user.get(), at.done, at.total) == 0 => {
                ControlFlow::Break(())
            }
            _ => ControlFlow::Continue(()),
        };
        Ok(bake(occluders, light, &self.settings, output, watch)?)
    }
}

/// # Safety
///
/// `out` is NULL, or can be written to.
unsafe fn tell(report: &BakeReport, out: *mut ds_report) -> Result<()> {
    if out.is_null() {
        return Ok(());
    }
    // SAFETY: as promised to this function.
    unsafe { write(out, report.into(), "report") }
}

/// Numbers an opacity of these hits: 1 or 3.
///
/// # Safety
///
/// `hits` are those that a hit function was called with, during that call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_hits_channels(hits: *const ds_hits) -> u32 {
    // SAFETY: the header asks for the hits of a call.
    unsafe { hits.as_ref() }.map_or(0, |hits| hits.channels() as u32)
}

/// Adds `count` surfaces: the number of a sample point of the tile each, a depth above 0 in scene
/// units along the camera's axis, and an opacity in [0, 1], or three of RGB maps.
///
/// # Safety
///
/// `hits` are those that a hit function was called with, during that call; the arrays are as
/// long as said.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_hits_add(
    hits: *mut ds_hits,
    count: usize,
    samples: *const u32,
    depths: *const f32,
    opacities: *const f32,
) -> ds_status {
    guard(|| {
        // SAFETY: the header asks for the hits of a call.
        let hits = unsafe { borrow_mut(hits, "hits") }?;
        let numbers = count.saturating_mul(hits.channels());
        // SAFETY: the header asks for arrays of these lengths.
        let (samples, depths, opacities) = unsafe {
            let columns = (slice(samples, count, "samples")?, slice(depths, count, "depths")?);
            (columns.0, columns.1, slice(opacities, numbers, "opacities")?)
        };
        hits.add(samples, depths, opacities)
    })
}

/// Adds `count` slabs of even density, which take `opacities` of the light between `near` and
/// `far` depths.
///
/// # Safety
///
/// As of ds_hits_add.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_hits_add_slabs(
    hits: *mut ds_hits,
    count: usize,
    samples: *const u32,
    near: *const f32,
    far: *const f32,
    opacities: *const f32,
) -> ds_status {
    guard(|| {
        // SAFETY: the header asks for the hits of a call.
        let hits = unsafe { borrow_mut(hits, "hits") }?;
        let channels = hits.channels();
        let numbers = count.saturating_mul(channels);
        // SAFETY: the header asks for arrays of these lengths.
        let (samples, near, far, opacities) = unsafe {
            let depths = (slice(near, count, "near")?, slice(far, count, "far")?);
            let opacities = slice(opacities, numbers, "opacities")?;
            (slice(samples, count, "samples")?, depths.0, depths.1, opacities)
        };
        let slabs = samples.iter().zip(near).zip(far).zip(opacities.chunks_exact(channels));
        for (((&sample, &near), &far), opacities) in slabs {
            hits.add_slab(sample, [near, far], opacities)?;
        }
        Ok(())
    })
}

/// The rays through `count` raster positions: an origin and a direction of three numbers each. A
/// direction goes one unit deep: origin + depth * direction is the point of the world.
///
/// # Safety
///
/// `view` is that of a tile, during the call that has it; the arrays are as long as said.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_view_rays(
    view: *const ds_view,
    count: usize,
    x: *const f64,
    y: *const f64,
    origins: *mut f64,
    directions: *mut f64,
) -> ds_status {
    guard(|| {
        // SAFETY: the header asks for the view of a tile.
        let view = unsafe { borrow(view, "view") }?.0;
        // SAFETY: the header asks for arrays of these lengths.
        let (x, y, origins, directions) = unsafe {
            let to: (&mut [[f64; 3]], &mut [[f64; 3]]) = (
                slice_mut(origins.cast(), count, "origins")?,
                slice_mut(directions.cast(), count, "directions")?,
            );
            (slice(x, count, "x")?, slice(y, count, "y")?, to.0, to.1)
        };
        for (index, (&x, &y)) in x.iter().zip(y).enumerate() {
            let ray = view.ray(x, y, 0.0);
            origins[index] = ray.origin().to_array();
            directions[index] = ray.direction().to_array();
        }
        Ok(())
    })
}
