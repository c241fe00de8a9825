//! Settings of bakes and queries, as C states them.

#![expect(unreachable_pub, reason = "C reaches them by their names")]

use std::ffi::{c_char, c_void};

use deepshadow::files::PyramidOptions;
use deepshadow::glam::DVec3;
use deepshadow::scene::Light;
use deepshadow::visibility::{
    Bias, Filter, FilterShape, Footprint, LevelChoice, LightExtent, Projection, Tolerance, View,
};
use deepshadow::{Bake, Channels, Kind, Method, MethodOptions, Query};

use crate::failure::{Failure, Result};

/// A query of a map; ds_query_init gives every field its default.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ds_query {
    /// "filter", "trace", "pcf" or "prefilter"; NULL: the map's own.
    pub method: *const c_char,
    /// "point", "box", "tent" or "gaussian"; NULL: point. Method filter.
    pub filter: *const c_char,
    /// Full width of the filter in pixels of level 0; NaN: the minimum. Method filter.
    pub width: f32,
    /// Mip level, 0 the finest; below 0: the one that fits the filter. Method filter.
    pub level: f64,
    /// Depth bias, or ray offset of method trace, in scene units; NaN: what is usual.
    pub bias: f32,
    /// Rays or taps; 0: 256. Methods trace and pcf.
    pub rays: u32,
    /// Full width and height of the map's light in scene units; NaN: as the map says.
    pub light_size: [f32; 2],
    /// Seed of methods that sample.
    pub seed: u64,
}

/// The shape of a light.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(non_camel_case_types, reason = "a name of C")]
pub enum ds_light_shape {
    /// A point.
    DS_POINT = 0,
    /// A rectangle of size[0] by size[1].
    DS_RECTANGLE = 1,
    /// A disk of diameter size[0].
    DS_DISK = 2,
    /// A sphere of diameter size[0].
    DS_SPHERE = 3,
}

/// A light and the camera that sits in it; ds_light_init gives every field its default.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ds_light {
    /// Where it stands, in the world.
    pub eye: [f64; 3],
    /// What it looks at, in the world.
    pub target: [f64; 3],
    /// Upwards, in the world.
    pub up: [f64; 3],
    /// Full angle of the wider side in degrees, in (0, 180).
    pub fov: f64,
    /// Full width of the wider side in scene units, of parallel rays; 0: perspective.
    pub extent: f64,
    /// One of ds_light_shape.
    pub shape: u32,
    /// Full width and height in scene units; of disks and spheres the diameter, twice.
    pub size: [f64; 2],
}

/// Called with what is done and of how much, from any thread; 0 ends the work.
#[expect(non_camel_case_types, reason = "a name of C")]
pub type ds_progress = Option<extern "C" fn(user: *mut c_void, done: u64, total: u64) -> i32>;

/// Settings of a bake; ds_bake_init gives every field its default.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ds_bake {
    /// The name of a kind; NULL: "deep".
    pub kind: *const c_char,
    /// Width in pixels; 0: what suits the kind and the scene.
    pub width: u32,
    /// Height in pixels; 0: as wide.
    pub height: u32,
    /// Samples a pixel; 0: what is usual for the kind.
    pub samples: u32,
    /// Bound of the error of every visibility function, in [0, 1); NaN: by the samples.
    pub tolerance: f32,
    /// 1 or 3 channels; 0: 3 if the scene has colours.
    pub channels: u32,
    /// Most layers of a pixel; 0: what is usual for the kind.
    pub layers: u32,
    /// Width and height of a tile in pixels; 0: 64.
    pub tile: u32,
    /// Not 0: with mip levels.
    pub mip: i32,
    /// Seed of the samples' places.
    pub seed: u64,
    /// NULL, or what is told of the work.
    pub progress: ds_progress,
    /// Handed to `progress`.
    pub user: *mut c_void,
}

/// Counts of a bake.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct ds_report {
    /// Samples of all pixels.
    pub samples: u64,
    /// Hits of all samples.
    pub hits: u64,
    /// Pixels with more layers than the map keeps.
    pub cut_pixels: u64,
    /// Length of the file in bytes.
    pub bytes: u64,
    /// The bound of the error of every visibility function.
    pub tolerance: f32,
    /// Numbers a value: 1 or 3.
    pub channels: u32,
}

fn given(number: f32) -> Option<f32> {
    (!number.is_nan()).then_some(number)
}

const fn more_than_none(number: u32) -> Option<u32> {
    if number == 0 { None } else { Some(number) }
}

impl ds_query {
    /// The query, with the words that its pointers lead to, of a map whose own method is
    /// `default`.
    pub(crate) fn query(
        &self,
        method: Option<&str>,
        filter: Option<&str>,
        default: Method,
    ) -> Result<Query> {
        let shape = match filter {
            None | Some("point") => None,
            Some("box") => Some(FilterShape::Box),
            Some("tent") => Some(FilterShape::Tent),
            Some("gaussian") => Some(FilterShape::Gaussian),
            Some(other) => {
                let reason = format!("filter: '{other}' is none of point, box, tent, gaussian");
                return Err(Failure::setting(reason));
            }
        };
        let footprint = match (shape, given(self.width)) {
            (None, None) => None,
            (None, Some(_)) => return Err(Failure::setting("width needs a filter")),
            (Some(shape), width) => {
                let filter = Filter::new(shape, width.unwrap_or(shape.minimum_width()))?;
                Some(Footprint::Isotropic(filter))
            }
        };
        let level = match self.level {
            0.0 => None,
            level if level < 0.0 => Some(LevelChoice::Auto),
            level if level.is_finite() => Some(LevelChoice::Fixed(level)),
            _ => return Err(Failure::setting("level: a finite number")),
        };
        if self.bias.is_infinite() {
            return Err(Failure::setting("bias: a finite number, or NaN"));
        }
        let options = MethodOptions {
            method: method.map(str::to_owned),
            footprint,
            level,
            bias: given(self.bias).map(Bias::Depth),
            rays: more_than_none(self.rays),
            ..MethodOptions::default()
        };
        let query = Query::new().with_seed(self.seed).with_method(options.method(default)?);
        let [width, height] = self.light_size;
        Ok(match (given(width), given(height)) {
            (Some(width), Some(height)) => query.with_light_size([width, height]),
            _ => query,
        })
    }
}

impl Default for ds_query {
    fn default() -> Self {
        let (method, filter) = (std::ptr::null(), std::ptr::null());
        let (width, bias, light_size) = (f32::NAN, f32::NAN, [f32::NAN; 2]);
        Self { method, filter, width, level: 0.0, bias, rays: 0, light_size, seed: 0 }
    }
}

impl ds_light {
    /// The light of the libraries, checked.
    pub(crate) fn light(&self) -> Result<Light> {
        let projection = if self.extent == 0.0 {
            Projection::Perspective { fov: self.fov }
        } else {
            Projection::Orthographic { extent: self.extent }
        };
        let [width, height] = self.size;
        const POINT: u32 = ds_light_shape::DS_POINT as u32;
        const RECTANGLE: u32 = ds_light_shape::DS_RECTANGLE as u32;
        const DISK: u32 = ds_light_shape::DS_DISK as u32;
        const SPHERE: u32 = ds_light_shape::DS_SPHERE as u32;
        let extent = match self.shape {
            POINT => LightExtent::POINT,
            RECTANGLE => LightExtent::rectangle([width, height]),
            DISK => LightExtent::disk(width / 2.0),
            SPHERE => LightExtent::sphere(width / 2.0),
            other => return Err(Failure::setting(format!("there is no light of shape {other}"))),
        };
        let [eye, target, up] = [self.eye, self.target, self.up].map(DVec3::from);
        let light = Light { view: View { eye, target, up }, projection, extent };
        light.area()?;
        light.raster([1, 1])?;
        Ok(light)
    }
}

impl Default for ds_light {
    fn default() -> Self {
        let (eye, target, up) = ([0.0, 1.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0]);
        let shape = ds_light_shape::DS_POINT as u32;
        Self { eye, target, up, fov: 45.0, extent: 0.0, shape, size: [0.0; 2] }
    }
}

impl ds_bake {
    /// The settings, of the kind of this name, and whether a size was told.
    pub(crate) fn settings(&self, kind: Option<&str>) -> Result<(Bake, bool)> {
        let name = kind.unwrap_or(Kind::DEEP.name());
        let Some(kind) = Kind::named(name) else {
            let names: Vec<_> = Kind::ALL.iter().map(|kind| kind.name()).collect();
            let reason = format!("kind: '{name}' is none of {}", names.join(", "));
            return Err(Failure::setting(reason));
        };
        let told = more_than_none(self.width)
            .map(|width| [width, more_than_none(self.height).unwrap_or(width)]);
        let size = told.or(kind.resolution()).unwrap_or([1024; 2]);
        let mut settings = Bake::new(size)?.with_kind(kind).with_seed(self.seed);
        settings.samples = more_than_none(self.samples);
        settings.tolerance = given(self.tolerance).map(Tolerance::new).transpose()?;
        settings.channels = match self.channels {
            0 => Channels::Auto,
            1 => Channels::Mono,
            3 => Channels::Rgb,
            other => {
                return Err(Failure::setting(format!("a map has 1 or 3 channels, not {other}")));
            }
        };
        settings.max_layers = more_than_none(self.layers);
        settings.tile_size = more_than_none(self.tile).unwrap_or(settings.tile_size);
        settings.pyramid = (self.mip != 0).then(PyramidOptions::default);
        settings.check()?;
        Ok((settings, told.is_some()))
    }
}

impl Default for ds_bake {
    fn default() -> Self {
        Self {
            kind: std::ptr::null(),
            width: 0,
            height: 0,
            samples: 0,
            tolerance: f32::NAN,
            channels: 0,
            layers: 0,
            tile: 0,
            mip: 0,
            seed: 0,
            progress: None,
            user: std::ptr::null_mut(),
        }
    }
}

impl From<&deepshadow::BakeReport> for ds_report {
    fn from(report: &deepshadow::BakeReport) -> Self {
        Self {
            samples: report.samples,
            hits: report.hits,
            cut_pixels: report.cut_pixels,
            bytes: report.bytes,
            tolerance: report.tolerance,
            // 1 or 3.
            channels: report.channels as u32,
        }
    }
}
