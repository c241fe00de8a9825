//! Multilayer transparent shadow maps (Xie, Tabellion & Pearce 2007, §5).

use std::path::Path;

use dsm_core::{Transmittance, ViewRaster};
use dsm_io::detail::Container;
use dsm_io::{Limits, MergeReport};
use mtsm::detail::bake_mtsm;
use mtsm::{MultilayerBaker, MultilayerSettings};

use super::layered::{self, BakeFromBehind};
use super::shadow_kind::{ShadowKind, join, refuse};
use crate::bake::Job;
use crate::bake::occluders::AnyHitSource;
use crate::bake::report::BakeReport;
use crate::bake::settings::Bake;
use crate::error::Result;
use crate::file::open_options::OpenOptions;
use crate::file::{CachedFile, OpenMap};
use crate::merge::MergeSettings;

/// Runs of compressed layers with counts.
pub(super) struct Mtsm;

impl ShadowKind for Mtsm {
    fn check(&self, settings: &Bake) -> Result<()> {
        if settings.coverage.is_some() {
            return refuse("--coverage", "fragments");
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
        join::<mtsm::detail::Mtsm>(maps, limits, output, settings)
    }

    fn open(&self, container: Container, options: &OpenOptions) -> Result<Box<dyn OpenMap>> {
        Ok(Box::new(CachedFile::<mtsm::detail::Mtsm>::open(container, options)?))
    }

    fn bake(&self, job: &Job<'_>, output: &Path) -> Result<BakeReport> {
        layered::bake::<Self>(job, output)
    }
}

impl BakeFromBehind for Mtsm {
    fn bake_seen<T: Transmittance>(
        job: &Job<'_>,
        view: &ViewRaster,
        light_depth: f32,
        source: AnyHitSource<'_, T>,
        output: &Path,
    ) -> Result<BakeReport> {
        let tolerance = MultilayerSettings::TOLERANCE;
        let settings = layered::settings(job, view, light_depth, tolerance)?;
        let (samples, tolerance) =
            (settings.bake.sampling.samples_per_pixel(), settings.tolerance());
        let baker = MultilayerBaker::<T, _>::new(source, settings)?;
        let describe = |metadata: &mut _| job.describe(metadata);
        let baked = bake_mtsm(&baker, output, job.settings.packing, describe, |at| job.watch(at))?;
        Ok(job.report::<T>(samples, tolerance, baked))
    }
}
