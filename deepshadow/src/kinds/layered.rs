//! Helpers for kinds of map for area lights.

use std::path::Path;
use std::sync::Arc;

use dsm_core::{
    AreaLight, BakeSettings, LightExtent, PixelSampling, Rgb, Tolerance, Transmittance, ViewRaster,
};
use dsm_io::Codec;
use dsm_io::detail::{CachedMap, ErasedMap, FieldKind, KindReader, MapKind};
use dsm_trace::detail::{CoherentShadow, LightFrame};
use mtsm::MultilayerSettings;
use mtsm::detail::{
    CachedLayers, FilteredLayers, LayeredKeys, MultilayerTracer, SoftPercentageCloser,
    TraceSettings, TracedMap,
};

use super::shadow_kind::refuse;
use crate::bake::occluders::AnyHitSource;
use crate::bake::report::BakeReport;
use crate::bake::settings::Bake;
use crate::bake::{Job, Seen};
use crate::error::{Error, Result};
use crate::file::texel_hits::{self, TexelHits};
use crate::file::{CachedFile, OpenMap};
use crate::query::method::Method;
use crate::query::settings::Query;
use crate::query::trace_method::TraceMethod;
use crate::shadow::handle::Shadow;
use crate::shadow::{AreaShadow, filtered_shadow};

/// Whether nothing was set that only deep maps have.
pub(super) fn check(settings: &Bake) -> Result<()> {
    if settings.pyramid.is_some() {
        return refuse("--mip", "deep");
    }
    if settings.codec == Codec::Quantized {
        return refuse("--codec quantized", "deep");
    }
    if settings.compression.is_some() {
        return refuse("compression by --method or --side", "deep");
    }
    if settings.target_size.is_some() {
        return refuse("--target-size", "deep");
    }
    if settings.depth_error.is_some() {
        return refuse("--depth-error", "deep");
    }
    Ok(())
}

/// The view of a map of an area light, from behind it by the depth that comes
/// with it, so that all that any point of the light sees is in the map (Xie et
/// al. 2007, equation 4).
fn view(job: &Job<'_>) -> Result<(ViewRaster, f32)> {
    let view = job.light.raster(job.settings.resolution)?;
    if !view.is_perspective() {
        let reason = "rays of an area light need a light with a perspective projection";
        return Err(Error::Unsupported(reason.to_owned()));
    }
    // The header keeps an f32.
    let depth = LightFrame::push_back(job.extent, view.half_size().to_array()) as f32;
    Ok((view.moved_back(depth.into()), depth))
}

/// The bake of a kind of map that looks from behind its light.
pub(super) trait BakeFromBehind {
    /// Bakes what `source` sees through `view`, which lies behind the light by
    /// `light_depth`.
    fn bake_seen<T: Transmittance>(
        job: &Job<'_>,
        view: &ViewRaster,
        light_depth: f32,
        source: AnyHitSource<'_, T>,
        output: &Path,
    ) -> Result<BakeReport>;
}

/// Bakes with as many channels as the map has.
pub(super) fn bake<K: BakeFromBehind>(job: &Job<'_>, output: &Path) -> Result<BakeReport> {
    let (view, light_depth) = view(job)?;
    match job.look(&view)? {
        Seen::Mono(source) => K::bake_seen(job, &view, light_depth, source, output),
        Seen::Rgb(source) => K::bake_seen(job, &view, light_depth, source, output),
    }
}

/// The settings of a map of layers.
pub(super) fn settings(
    job: &Job<'_>,
    view: &ViewRaster,
    light_depth: f32,
    tolerance: f32,
) -> Result<MultilayerSettings> {
    let asked = job.settings;
    let mut bake = BakeSettings::new(asked.resolution)?;
    bake.tile_size = asked.tile_size;
    bake.crop = asked.crop;
    bake.sampling = match asked.samples {
        None | Some(1) => PixelSampling::centre(),
        Some(samples) => PixelSampling::new(samples, asked.seed)?,
    };
    bake.filter = asked.filter;
    bake.tolerance = match asked.tolerance {
        Some(tolerance) => Some(tolerance),
        None => Some(Tolerance::new(tolerance)?),
    };
    bake.camera = Some(view.shadow_camera());
    let resets = asked.resets.unwrap_or(MultilayerSettings::RESETS);
    let max_layers = asked.max_layers.unwrap_or(MultilayerSettings::MAX_LAYERS);
    Ok(MultilayerSettings { bake, resets, max_layers, light_depth })
}

/// Kinds of files whose layers have a depth alone: traced, or filtered.
trait LayersInFile: FieldKind<Keys = LayeredKeys> {
    /// What a file shows through the middle of every pixel, if it tells.
    fn texel_hits(_file: &CachedFile<Self>) -> Option<Result<TexelHits>> {
        None
    }
}

impl LayersInFile for mtsm::detail::Layers {
    fn texel_hits(file: &CachedFile<Self>) -> Option<Result<TexelHits>> {
        Some(match file {
            CachedFile::Mono(map) => texel_hits::of_layers(map.reader()).map(TexelHits::Mono),
            CachedFile::Rgb(map) => texel_hits::of_layers(map.reader()).map(TexelHits::Rgb),
        })
    }
}

impl LayersInFile for mtsm::detail::Mtsm {}

impl<K: LayersInFile> OpenMap for CachedFile<K>
where
    CachedLayers<f32, K>: TracedMap<Error = dsm_io::Error, BuildError = dsm_io::Error>,
    CachedLayers<Rgb, K>: TracedMap<Error = dsm_io::Error, BuildError = dsm_io::Error>,
{
    fn file(&self) -> &dyn ErasedMap {
        self.reader()
    }

    fn default_method(&self) -> Method {
        TraceMethod::default().into()
    }

    fn shadow(&self, query: &Query) -> Result<Shadow> {
        let method = query.method.unwrap_or(self.default_method());
        match self {
            Self::Mono(map) => shadow(map, method, query),
            Self::Rgb(map) => shadow(map, method, query),
        }
    }

    fn texel_hits(&self) -> Option<Result<TexelHits>> {
        K::texel_hits(self)
    }
}

/// The shadows of layers that have a depth alone.
fn shadow<T, K>(map: &CachedMap<T, K>, method: Method, query: &Query) -> Result<Shadow>
where
    T: Transmittance,
    K: FieldKind<Keys = LayeredKeys>,
    CachedLayers<T, K>: TracedMap<Error = dsm_io::Error, BuildError = dsm_io::Error>,
{
    let reader = map.reader();
    let layers = Arc::new(CachedLayers::new(map.clone()));
    match method {
        Method::Trace(asked) => {
            if asked.far_table.is_some() {
                let reason = "--far-table is for maps of kind fragments";
                return Err(Error::query(reader, reason));
            }
            let default = TraceSettings::default();
            let settings = TraceSettings {
                rule: asked.rule.unwrap_or(default.rule),
                depth_threshold: asked.depth_threshold.unwrap_or(default.depth_threshold),
                start: asked.start,
                rays: asked.rays,
                ..default
            };
            let tracer = MultilayerTracer::new(layers, settings)?;
            let light = light(query, reader, tracer.frame())?;
            Ok(Shadow::new(Box::new(AreaShadow(tracer)), light, query.seed))
        }
        Method::Coherence(asked) => {
            let settings = TraceSettings { start: asked.start, ..TraceSettings::default() };
            let tracer = MultilayerTracer::new(layers, settings)?;
            let light = light(query, reader, tracer.frame())?;
            let shadow = CoherentShadow::new(tracer, asked.settings(false));
            Ok(Shadow::new(Box::new(AreaShadow(shadow)), light, query.seed))
        }
        Method::Pcf(asked) => {
            let filter = SoftPercentageCloser::new(layers, FilteredLayers::All)?;
            let filter = filter.with_taps(asked.taps)?;
            let filter = match asked.bias {
                Some(bias) => filter.with_bias(bias)?,
                None => filter.with_pixel_bias(),
            };
            let light = light(query, reader, filter.frame())?;
            Ok(Shadow::new(Box::new(AreaShadow(filter)), light, query.seed))
        }
        Method::Filter(method) => filtered_shadow(map, method, query),
        Method::Attenuation(_) => {
            let reason = "it holds occluders, no shadows: a map of kind attenuation has those";
            Err(Error::query(reader, reason))
        }
        Method::Prefilter(_) | Method::Hybrid(_) => Err(Error::query(
            reader,
            "it has no levels of wider filters: a map \
                                                          of kind prefiltered has",
        )),
    }
}

/// The light that a query asks for: its own, or that of the map's header, of
/// another size if one is given.
pub(super) fn light<K: MapKind>(
    query: &Query,
    map: &KindReader<K>,
    frame: &LightFrame,
) -> Result<AreaLight> {
    if let Some(light) = query.light {
        return Ok(light);
    }
    let known = map.metadata().info.light;
    let Some(size) = query.light_size else {
        let reason = "the map does not say what its light is: --light-size does";
        return known.map(|extent| frame.area_light(extent)).ok_or(Error::query(map, reason));
    };
    let extent = known.unwrap_or(LightExtent::POINT).with_size(size.map(f64::from));
    let reason = "--light-size: a disk or a sphere is as high as wide";
    extent.map(|extent| frame.area_light(extent)).ok_or_else(|| Error::query(map, reason))
}
