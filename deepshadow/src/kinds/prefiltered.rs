//! Prefiltered maps (Selgrad, Dachsbacher, Meyer & Stamminger 2014).

use std::convert::Infallible;
use std::path::Path;
use std::sync::Arc;

use dsm_core::{OcclusionTracer, Rgb, Tolerance, Transmittance, ViewRaster};
use dsm_io::detail::{CachedMap, Container, ErasedMap};
use dsm_io::{Limits, MergeReport, WriteOptions};
use dsm_scene::detail::SceneReference;
use shadow_maps::detail::{
    CachedPrefiltered, HybridShadow, ListBuilder, Prefiltered as PrefilteredKind,
    PrefilteredShadow, bake_prefiltered,
};

use super::layered;
use super::layers::check_surfaces;
use super::shadow_kind::{ShadowKind, join, refuse};
use crate::bake::occluders::AnyHitSource;
use crate::bake::report::BakeReport;
use crate::bake::settings::Bake;
use crate::bake::{Job, Seen};
use crate::error::{Error, Result};
use crate::file::open_options::OpenOptions;
use crate::file::{AnyTracer, CachedFile, Near, OpenMap};
use crate::merge::MergeSettings;
use crate::query::hybrid_method::HybridMethod;
use crate::query::method::Method;
use crate::query::prefilter_method::PrefilterMethod;
use crate::query::settings::Query;
use crate::shadow::AreaShadow;
use crate::shadow::handle::Shadow;

/// Fragments in levels of wider and wider filters.
pub(super) struct Prefiltered;

impl ShadowKind for Prefiltered {
    fn check(&self, settings: &Bake) -> Result<()> {
        if settings.coverage.is_some() {
            return refuse("--coverage", "fragments");
        }
        if settings.crop.is_some() {
            let reason = "--crop: levels of a prefiltered map reach across it: bake crops of kind \
                          fragments or layers, merge them, and bake the merged map to --kind \
                          prefiltered";
            return Err(Error::Unsupported(reason.to_owned()));
        }
        check_surfaces(settings)
    }

    fn is_filtered(&self) -> bool {
        true
    }

    fn merge(
        &self,
        maps: Vec<Container>,
        limits: &Limits,
        output: &Path,
        settings: &mut MergeSettings<'_>,
    ) -> Result<MergeReport> {
        join::<PrefilteredKind>(maps, limits, output, settings)
    }

    fn open(&self, container: Container, options: &OpenOptions) -> Result<Box<dyn OpenMap>> {
        Ok(Box::new(CachedFile::<PrefilteredKind>::open(container, options)?))
    }

    /// From the light's centre: then all filters around a place are those around one
    /// texel.
    fn bake(&self, job: &Job<'_>, output: &Path) -> Result<BakeReport> {
        let view = job.light.raster(job.settings.resolution)?;
        if !view.is_perspective() {
            let reason = "soft shadows of an area light need a light with a perspective projection";
            return Err(Error::Unsupported(reason.to_owned()));
        }
        match job.look(&view)? {
            Seen::Mono(source) => bake(job, &view, source, output),
            Seen::Rgb(source) => bake(job, &view, source, output),
        }
    }
}

fn bake<T: Transmittance>(
    job: &Job<'_>,
    view: &ViewRaster,
    source: AnyHitSource<'_, T>,
    output: &Path,
) -> Result<BakeReport> {
    let asked = job.settings;
    let mut builder = ListBuilder::new(view.shadow_camera(), asked.resolution, 0.0)?;
    if let Some(layers) = asked.max_layers {
        builder = builder.with_layers(layers)?;
    }
    let filtering = asked.filtering.unwrap_or_default();
    let options =
        WriteOptions::default().with_tile_size(asked.tile_size).with_packing(asked.packing);
    let describe = |metadata: &mut _| job.describe(metadata);
    let watch = |at| job.watch(at);
    let baked =
        bake_prefiltered::<T, _>(&builder, &filtering, &source, output, options, describe, watch)?;
    Ok(job.report::<T>(1, Tolerance::EXACT, baked))
}

impl OpenMap for CachedFile<PrefilteredKind> {
    fn file(&self) -> &dyn ErasedMap {
        self.reader()
    }

    fn default_method(&self) -> Method {
        PrefilterMethod::new().into()
    }

    fn shadow(&self, query: &Query) -> Result<Shadow> {
        let Method::Prefilter(method) = query.method.unwrap_or(self.default_method()) else {
            let reason = match query.method {
                Some(Method::Hybrid(_)) => {
                    "--method hybrid needs a scene or a map of kind fragments for its short rays"
                }
                _ => {
                    "a prefiltered map has no layers to trace and no functions to filter: --method \
                     prefilter reads it"
                }
            };
            return Err(Error::query(self.reader(), reason));
        };
        match self {
            Self::Mono(map) => shadow(map, method, query),
            Self::Rgb(map) => shadow(map, method, query),
        }
    }

    fn hybrid(&self, query: &Query, near: &Near<'_>) -> Option<Result<Shadow>> {
        let method = match query.method {
            Some(Method::Hybrid(method)) => method,
            _ => HybridMethod::default(),
        };
        Some(match (self, near) {
            (Self::Mono(map), Near::Scene(scene)) => {
                hybrid(map, SceneReference::<f32>::new(Arc::clone(scene)), method, query)
            }
            (Self::Rgb(map), Near::Scene(scene)) => {
                hybrid(map, SceneReference::<Rgb>::new(Arc::clone(scene)), method, query)
            }
            (_, Near::Map(other)) => match (self, other.tracer()) {
                (Self::Mono(map), Some(Ok(AnyTracer::Mono(tracer)))) => {
                    hybrid(map, tracer, method, query)
                }
                (Self::Rgb(map), Some(Ok(AnyTracer::Rgb(tracer)))) => {
                    hybrid(map, tracer, method, query)
                }
                (_, Some(Err(error))) => Err(error),
                _ => {
                    let reason = "short rays need a map of kind fragments with as many channels";
                    Err(Error::query(self.reader(), reason))
                }
            },
        })
    }
}

/// The lookups of a map.
fn lookups<T: Transmittance>(
    map: &CachedMap<T, PrefilteredKind>,
    method: PrefilterMethod,
) -> Result<PrefilteredShadow<CachedPrefiltered<T>>> {
    let known = map.reader().keys().filtering;
    let lists = CachedPrefiltered::<T>::new(map.clone())?;
    let shadow = PrefilteredShadow::new(lists)
        .with_accumulate(method.accumulate.unwrap_or(known.accumulate))
        .with_splits(method.splits.unwrap_or(1));
    Ok(match method.bias {
        Some(bias) => shadow.with_bias(bias)?,
        None => shadow,
    })
}

fn shadow<T: Transmittance>(
    map: &CachedMap<T, PrefilteredKind>,
    method: PrefilterMethod,
    query: &Query,
) -> Result<Shadow> {
    let shadow = lookups(map, method)?;
    let light = layered::light(query, map.reader(), shadow.frame())?;
    Ok(Shadow::new(Box::new(AreaShadow(shadow)), light, query.seed))
}

fn hybrid<T, N>(
    map: &CachedMap<T, PrefilteredKind>,
    near: N,
    method: HybridMethod,
    query: &Query,
) -> Result<Shadow>
where
    T: Transmittance,
    N: OcclusionTracer<Value = T, Error = Infallible> + Send + 'static,
{
    let shadow = HybridShadow::new(lookups(map, method.lookup)?, near).with_rays(method.rays);
    let shadow = match method.reach {
        Some(texels) => shadow.with_reach(texels)?,
        None => shadow,
    };
    let light = layered::light(query, map.reader(), shadow.frame())?;
    Ok(Shadow::new(Box::new(AreaShadow(shadow)), light, query.seed))
}
