//! Layered attenuation maps (Agrawala, Ramamoorthi, Heirich & Moll 2000).

use std::ops::ControlFlow;
use std::path::Path;

use dsm_core::{AreaLight, LightExtent, Progress, Rgb, Tolerance, Transmittance, ViewRaster};
use dsm_io::detail::{CachedMap, Container, ErasedMap};
use dsm_io::{Limits, MergeReport, WriteOptions};
use shadow_maps::detail::{
    Attenuation as AttenuationKind, AttenuationBuilder, AttenuationShadow, CachedAttenuation,
    write_attenuation,
};

use super::layers::check_surfaces;
use super::shadow_kind::{ShadowKind, join, refuse};
use crate::bake::Job;
use crate::bake::occluders::AnyHitSource;
use crate::bake::report::BakeReport;
use crate::bake::settings::Bake;
use crate::error::{Error, Result};
use crate::file::open_options::OpenOptions;
use crate::file::{CachedFile, OpenMap};
use crate::merge::MergeSettings;
use crate::query::attenuation_method::AttenuationMethod;
use crate::query::method::Method;
use crate::query::settings::Query;
use crate::shadow::AreaShadow;
use crate::shadow::handle::Shadow;

/// Points of a light unless another number is asked for.
const LIGHT_SAMPLES: u32 = 64;

/// Rounding of sizes in headers, relative.
const ROUNDING: f64 = 1.0 / (1 << 20) as f64;

/// What each place sees of the light.
pub(super) struct Attenuation;

impl ShadowKind for Attenuation {
    fn check(&self, settings: &Bake) -> Result<()> {
        if settings.coverage.is_some() {
            return refuse("--coverage", "fragments");
        }
        if settings.max_layers.is_some() {
            return refuse("--layers", "fragments, layers, mtsm or prefiltered");
        }
        if settings.light_samples == Some(0) {
            let reason = "an attenuation map is of one point of its light or more";
            return Err(Error::Unsupported(reason.to_owned()));
        }
        if settings.crop.is_some() {
            let reason = "--crop: each pixel of a map of kind attenuation takes what all points of \
                          the light see, so that a part costs as much as the whole: bake it whole";
            return Err(Error::Unsupported(reason.to_owned()));
        }
        check_surfaces(settings)
    }

    fn has_light_samples(&self) -> bool {
        true
    }

    fn merge(
        &self,
        maps: Vec<Container>,
        limits: &Limits,
        output: &Path,
        settings: &mut MergeSettings<'_>,
    ) -> Result<MergeReport> {
        join::<AttenuationKind>(maps, limits, output, settings)
    }

    fn open(&self, container: Container, options: &OpenOptions) -> Result<Box<dyn OpenMap>> {
        Ok(Box::new(CachedFile::<AttenuationKind>::open(container, options)?))
    }

    fn bake(&self, job: &Job<'_>, output: &Path) -> Result<BakeReport> {
        let view = job.light.raster(job.settings.resolution)?;
        if !view.is_perspective() {
            let reason = "soft shadows of an area light need a light with a perspective projection";
            return Err(Error::Unsupported(reason.to_owned()));
        }
        if job.is_coloured() {
            bake::<Rgb>(job, &view, |view| job.rgb(view), output)
        } else {
            bake::<f32>(job, &view, |view| job.mono(view), output)
        }
    }
}

/// From points of the light, each of which sees what `look` tells.
fn bake<'a, T: Transmittance>(
    job: &Job<'_>,
    view: &ViewRaster,
    look: impl Fn(&ViewRaster) -> Result<AnyHitSource<'a, T>>,
    output: &Path,
) -> Result<BakeReport> {
    let asked = job.settings;
    let mut builder = AttenuationBuilder::<T>::new(view.shadow_camera(), asked.resolution)?;
    let light = builder.frame().area_light(job.extent);
    // All points of a point are one.
    let is_point = job.extent.size() == [0.0; 2];
    let count = if is_point { 1 } else { asked.light_samples.unwrap_or(LIGHT_SAMPLES) };
    // Of a sphere the disk that the middle of the map sees.
    let before = light.centre() - view.basis().z_axis;
    let rows = u64::from(asked.resolution[1].div_ceil(16));
    for (number, eye) in (0..).zip(light.samples(before, count, asked.seed)) {
        let view = view.at_eye(eye);
        let source = look(&view)?;
        let mut done = number * rows;
        let watch = || {
            let progress = Progress::new(done, rows * u64::from(count));
            done += 1;
            job.watch(progress)
        };
        let added = builder.add_view(&source, view.shadow_camera(), watch);
        match added.map_err(|error| dsm_io::Error::HitSource(Box::new(error)))? {
            ControlFlow::Continue(()) => {}
            ControlFlow::Break(()) => return Err(Error::Interrupted),
        }
    }
    let options =
        WriteOptions::default().with_tile_size(asked.tile_size).with_packing(asked.packing);
    let baked = write_attenuation(&builder, output, options, |metadata| job.describe(metadata))?;
    Ok(job.report::<T>(count, Tolerance::EXACT, baked))
}

impl OpenMap for CachedFile<AttenuationKind> {
    fn file(&self) -> &dyn ErasedMap {
        self.reader()
    }

    fn default_method(&self) -> Method {
        AttenuationMethod::new().into()
    }

    fn shadow(&self, query: &Query) -> Result<Shadow> {
        let Method::Attenuation(method) = query.method.unwrap_or(self.default_method()) else {
            let reason = "an attenuation map holds shadows, no occluders: --method attenuation \
                          reads it";
            return Err(Error::query(self.reader(), reason));
        };
        match self {
            Self::Mono(map) => shadow(map, method, query),
            Self::Rgb(map) => shadow(map, method, query),
        }
    }
}

fn shadow<T: Transmittance>(
    map: &CachedMap<T, AttenuationKind>,
    method: AttenuationMethod,
    query: &Query,
) -> Result<Shadow> {
    let reader = map.reader();
    let lookups = CachedAttenuation::<T>::new(map.clone())?;
    let shadow = AttenuationShadow::new(lookups).with_bilinear(method.bilinear);
    let shadow = match method.bias {
        Some(bias) => shadow.with_bias(bias)?,
        None => shadow,
    };
    let known = reader.metadata().info.light.unwrap_or(LightExtent::POINT);
    let asked = query.light.as_ref().map(AreaLight::extent);
    let size = query.light_size.and_then(|size| known.with_size(size.map(f64::from)));
    let is_other = asked.or(size).is_some_and(|asked| !is_same(asked, known));
    if is_other || query.light_size.is_some() && size.is_none() {
        let reason = "an attenuation map holds the shadows of the light that it was baked for, no \
                      other's: bake it again";
        return Err(Error::query(reader, reason));
    }
    let light = query.light.unwrap_or_else(|| shadow.frame().area_light(known));
    Ok(Shadow::new(Box::new(AreaShadow(shadow)), light, query.seed))
}

/// Whether two lights are one, but for the rounding of headers.
fn is_same(a: LightExtent, b: LightExtent) -> bool {
    let [one, other] = [a.size(), b.size()];
    let close = |axis: usize| (one[axis] - other[axis]).abs() <= ROUNDING * one[axis].abs();
    close(0) && close(1) && (a.shape() == b.shape() || one == [0.0; 2])
}
