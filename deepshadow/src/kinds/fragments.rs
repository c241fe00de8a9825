//! Maps of fragments: planes with coverage masks, and media beside them.

use std::path::Path;

use dsm_core::{Transmittance, ViewRaster};
use dsm_io::detail::{CachedMap, Container, ErasedMap};
use dsm_io::{Limits, MergeReport, WriteOptions};
use shadow_maps::detail::{
    CollectedHits, FragmentBuilder, FragmentTracer, Fragments as FragmentsKind, bake_fragments,
};

use super::layered::{self, BakeFromBehind};
use super::shadow_kind::{ShadowKind, join, refuse};
use crate::bake::Job;
use crate::bake::occluders::AnyHitSource;
use crate::bake::report::BakeReport;
use crate::bake::settings::Bake;
use crate::error::{Error, Result};
use crate::file::open_options::OpenOptions;
use crate::file::texel_hits::{self, TexelHits};
use crate::file::{AnyTracer, CachedFile, OpenMap};
use crate::merge::MergeSettings;
use crate::query::method::Method;
use crate::query::settings::Query;
use crate::query::trace_method::{FarTable, TraceMethod};
use crate::shadow::AreaShadow;
use crate::shadow::handle::Shadow;

/// Places along a side of a pixel unless another number is asked for.
const COVERAGE: u32 = 8;

/// Planes with coverage masks, and media beside them.
pub(super) struct Fragments;

impl ShadowKind for Fragments {
    fn check(&self, settings: &Bake) -> Result<()> {
        if settings.coverage.is_some_and(|side| ![1, 2, 4, 8].contains(&side)) {
            let reason = "a side of a pixel has 1, 2, 4 or 8 places that are covered or not";
            return Err(Error::Unsupported(reason.to_owned()));
        }
        let places = settings.coverage.unwrap_or(COVERAGE).pow(2);
        if settings.samples.is_some_and(|times| !(1..=places).contains(&times)) {
            let reason = "the samples of a map of fragments are times that the places of a pixel \
                          (--coverage) are shared out to: 1 to as many as those";
            return Err(Error::Unsupported(reason.to_owned()));
        }
        if settings.resets.is_some() {
            return refuse("--resets", "mtsm");
        }
        layered::check(settings)
    }

    fn merge(
        &self,
        maps: Vec<Container>,
        limits: &Limits,
        output: &Path,
        settings: &mut MergeSettings<'_>,
    ) -> Result<MergeReport> {
        join::<FragmentsKind>(maps, limits, output, settings)
    }

    fn open(&self, container: Container, options: &OpenOptions) -> Result<Box<dyn OpenMap>> {
        Ok(Box::new(CachedFile::<FragmentsKind>::open(container, options)?))
    }

    fn bake(&self, job: &Job<'_>, output: &Path) -> Result<BakeReport> {
        layered::bake::<Self>(job, output)
    }
}

impl BakeFromBehind for Fragments {
    fn bake_seen<T: Transmittance>(
        job: &Job<'_>,
        view: &ViewRaster,
        light_depth: f32,
        source: AnyHitSource<'_, T>,
        output: &Path,
    ) -> Result<BakeReport> {
        let asked = job.settings;
        let coverage = asked.coverage.unwrap_or(COVERAGE);
        let mut builder =
            FragmentBuilder::new(view.shadow_camera(), asked.resolution, light_depth.into())?
                .with_coverage(coverage)?
                .with_times(asked.samples.unwrap_or(1), asked.seed)?;
        if let Some(layers) = asked.max_layers {
            builder = builder.with_layers(layers)?;
        }
        if let Some(tolerance) = asked.tolerance {
            builder = builder.with_tolerance(tolerance);
        }
        let describe = |metadata: &mut _| job.describe(metadata);
        let options =
            WriteOptions::default().with_tile_size(asked.tile_size).with_packing(asked.packing);
        let (baked, tolerance) = bake_fragments::<T, _>(
            &builder,
            &source,
            (output, job.crop()),
            options,
            describe,
            |at| job.watch(at),
        )?;
        Ok(job.report::<T>(coverage * coverage, tolerance, baked))
    }
}

impl OpenMap for CachedFile<FragmentsKind> {
    fn file(&self) -> &dyn ErasedMap {
        self.reader()
    }

    fn default_method(&self) -> Method {
        TraceMethod::default().into()
    }

    fn shadow(&self, query: &Query) -> Result<Shadow> {
        let refuse = |reason| Err(Error::query(self.reader(), reason));
        let Method::Trace(method) = query.method.unwrap_or(self.default_method()) else {
            return refuse("fragments are traced: a map of kind layers or mtsm can be filtered");
        };
        if method.has_layer_rules() {
            return refuse(
                "fragments have planes; --rule and --z-threshold are for maps of kind layers and \
                 mtsm",
            );
        }
        match self {
            Self::Mono(map) => shadow(map, method, query),
            Self::Rgb(map) => shadow(map, method, query),
        }
    }

    fn tracer(&self) -> Option<Result<AnyTracer>> {
        Some(match self {
            Self::Mono(map) => {
                FragmentTracer::read(map.reader()).map(AnyTracer::Mono).map_err(Error::from)
            }
            Self::Rgb(map) => {
                FragmentTracer::read(map.reader()).map(AnyTracer::Rgb).map_err(Error::from)
            }
        })
    }

    fn texel_hits(&self) -> Option<Result<TexelHits>> {
        Some(match self {
            Self::Mono(map) => surfaces(map).map(TexelHits::Mono),
            Self::Rgb(map) => surfaces(map).map(TexelHits::Rgb),
        })
    }
}

/// The surfaces of a map, if it holds nothing else.
fn surfaces<T: Transmittance>(map: &CachedMap<T, FragmentsKind>) -> Result<CollectedHits<T>> {
    if map.reader().keys().media.is_some() {
        let reason = "it has media, which are no surfaces: take a deep map of the scene";
        return Err(Error::query(map.reader(), reason));
    }
    texel_hits::of_fragments(map.reader())
}

fn shadow<T: Transmittance>(
    map: &CachedMap<T, FragmentsKind>,
    method: TraceMethod,
    query: &Query,
) -> Result<Shadow> {
    let tracer = FragmentTracer::<T>::read(map.reader())?;
    let light = layered::light(query, map.reader(), tracer.frame())?;
    // Before the rest is set, so that map and light alone decide.
    let tracer = match method.far_table.unwrap_or_default() {
        FarTable::Auto => tracer.for_light(&light),
        FarTable::On => tracer.with_far_table(FragmentTracer::<T>::NEAR_CELLS),
        FarTable::Off => tracer,
    };
    let tracer = tracer.with_rays(method.rays);
    let tracer = match method.start {
        Some(start) => tracer.with_start(start, start),
        None => tracer,
    };
    Ok(Shadow::new(Box::new(AreaShadow(tracer)), light, query.seed))
}
