//! Multilayer depth maps (Xie, Tabellion & Pearce 2007, §4.2).

use std::path::Path;

use dsm_core::{Tolerance, Transmittance, ViewRaster};
use dsm_io::detail::{Container, ErasedMap};
use mtsm::MultilayerBaker;
use mtsm::detail::bake_layers;

use super::layered;
use super::shadow_kind::{ShadowKind, refuse};
use crate::bake::occluders::AnyHitSource;
use crate::bake::report::BakeReport;
use crate::bake::settings::Bake;
use crate::bake::{Job, Seen};
use crate::error::{Error, Result};
use crate::file::open_options::OpenOptions;
use crate::file::{CachedFile, OpenMap};
use crate::query::method::Method;
use crate::query::settings::Query;
use crate::query::trace_method::TraceMethod;
use crate::shadow::handle::Shadow;

/// The first hits of every pixel's centre.
pub(super) struct Layers;

impl ShadowKind for Layers {
    fn check(&self, settings: &Bake) -> Result<()> {
        if settings.coverage.is_some() {
            return refuse("--coverage", "fragments");
        }
        check_surfaces(settings)
    }

    fn open(&self, container: Container, options: &OpenOptions) -> Result<Box<dyn OpenMap>> {
        Ok(Box::new(CachedFile::<mtsm::detail::Layers>::open(container, options)?))
    }

    fn bake(&self, job: &Job<'_>, output: &Path) -> Result<BakeReport> {
        let (view, light_depth) = layered::view(job)?;
        match job.look(&view)? {
            Seen::Mono(source) => bake(job, &view, light_depth, source, output),
            Seen::Rgb(source) => bake(job, &view, light_depth, source, output),
        }
    }
}

/// Whether nothing was set that kinds which keep surfaces as they are do not have.
pub(super) fn check_surfaces(settings: &Bake) -> Result<()> {
    layered::check(settings)?;
    if settings.resets.is_some() {
        return refuse("--resets", "mtsm");
    }
    if settings.tolerance.is_some() {
        return refuse("--tolerance", "deep or mtsm");
    }
    if settings.samples.is_some_and(|samples| samples != 1) {
        let kind = settings.kind.name();
        return Err(Error::Unsupported(format!("a map of kind {kind} has one sample a pixel")));
    }
    Ok(())
}

fn bake<T: Transmittance>(
    job: &Job<'_>,
    view: &ViewRaster,
    light_depth: f32,
    source: AnyHitSource<'_, T>,
    output: &Path,
) -> Result<BakeReport> {
    let settings = layered::settings(job, view, light_depth, 0.0)?;
    let baker = MultilayerBaker::<T, _>::new(source, settings)?;
    let describe = |metadata: &mut _| job.describe(metadata);
    let baked = bake_layers(&baker, output, job.settings.packing, describe, |at| job.watch(at))?;
    Ok(job.report::<T>(1, Tolerance::EXACT, baked))
}

impl OpenMap for CachedFile<mtsm::detail::Layers> {
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
