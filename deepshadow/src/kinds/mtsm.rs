//! Multilayer transparent shadow maps (Xie, Tabellion & Pearce 2007, §5).

use std::path::Path;

use dsm_core::{Transmittance, ViewRaster};
use dsm_io::detail::{Container, ErasedMap};
use mtsm::detail::bake_mtsm;
use mtsm::{MultilayerBaker, MultilayerSettings};

use super::layered;
use super::shadow_kind::{ShadowKind, refuse};
use crate::bake::occluders::AnyHitSource;
use crate::bake::report::BakeReport;
use crate::bake::settings::Bake;
use crate::bake::{Job, Seen};
use crate::error::Result;
use crate::file::open_options::OpenOptions;
use crate::file::{CachedFile, OpenMap};
use crate::query::method::Method;
use crate::query::settings::Query;
use crate::query::trace_method::TraceMethod;
use crate::shadow::handle::Shadow;

/// Runs of compressed layers with counts.
pub(super) struct Mtsm;

impl ShadowKind for Mtsm {
    fn check(&self, settings: &Bake) -> Result<()> {
        if settings.coverage.is_some() {
            return refuse("--coverage", "fragments");
        }
        layered::check(settings)
    }

    fn open(&self, container: Container, options: &OpenOptions) -> Result<Box<dyn OpenMap>> {
        Ok(Box::new(CachedFile::<mtsm::detail::Mtsm>::open(container, options)?))
    }

    fn bake(&self, job: &Job<'_>, output: &Path) -> Result<BakeReport> {
        let (view, light_depth) = layered::view(job)?;
        match job.look(&view)? {
            Seen::Mono(source) => bake(job, &view, light_depth, source, output),
            Seen::Rgb(source) => bake(job, &view, light_depth, source, output),
        }
    }
}

fn bake<T: Transmittance>(
    job: &Job<'_>,
    view: &ViewRaster,
    light_depth: f32,
    source: AnyHitSource<'_, T>,
    output: &Path,
) -> Result<BakeReport> {
    let tolerance = MultilayerSettings::TOLERANCE;
    let settings = layered::settings(job, view, light_depth, tolerance)?;
    let (samples, tolerance) = (settings.bake.sampling.samples_per_pixel(), settings.tolerance());
    let baker = MultilayerBaker::<T, _>::new(source, settings)?;
    let describe = |metadata: &mut _| job.describe(metadata);
    let baked = bake_mtsm(&baker, output, job.settings.packing, describe, |at| job.watch(at))?;
    Ok(job.report::<T>(samples, tolerance, baked))
}

impl OpenMap for CachedFile<mtsm::detail::Mtsm> {
    fn file(&self) -> &dyn ErasedMap {
        self.reader()
    }

    fn default_method(&self) -> Method {
        TraceMethod::default().into()
    }

    fn shadow(&self, query: &Query) -> Result<Shadow> {
        let method = query.method.unwrap_or(self.default_method());
        match self {
            Self::Mono(map) => layered::shadow(map, method, query),
            Self::Rgb(map) => layered::shadow(map, method, query),
        }
    }
}
