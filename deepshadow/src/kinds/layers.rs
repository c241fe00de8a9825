//! Multilayer depth maps (Xie, Tabellion & Pearce 2007, §4.2).

use std::path::Path;

use dsm_core::{PixelSampling, Tolerance, Transmittance, ViewRaster};
use dsm_io::detail::Container;
use dsm_io::{Limits, MergeReport};
use mtsm::MultilayerBaker;
use mtsm::detail::bake_layers;

use super::layered::{self, BakeFromBehind};
use super::shadow_kind::{ShadowKind, join, refuse};
use crate::bake::Job;
use crate::bake::occluders::AnyHitSource;
use crate::bake::report::BakeReport;
use crate::bake::settings::Bake;
use crate::error::{Error, Result};
use crate::file::open_options::OpenOptions;
use crate::file::{CachedFile, OpenMap};
use crate::merge::MergeSettings;

/// The first hits of every pixel's centre, at one time or several.
pub(super) struct Layers;

impl ShadowKind for Layers {
    fn check(&self, settings: &Bake) -> Result<()> {
        if settings.coverage.is_some() {
            return refuse("--coverage", "fragments");
        }
        // Its samples are times.
        PixelSampling::centre_over_time(settings.samples.unwrap_or(1), settings.seed)?;
        check_surfaces(&Bake { samples: None, ..settings.clone() })
    }

    fn merge(
        &self,
        maps: Vec<Container>,
        limits: &Limits,
        output: &Path,
        settings: &mut MergeSettings<'_>,
    ) -> Result<MergeReport> {
        join::<mtsm::detail::Layers>(maps, limits, output, settings)
    }

    fn open(&self, container: Container, options: &OpenOptions) -> Result<Box<dyn OpenMap>> {
        Ok(Box::new(CachedFile::<mtsm::detail::Layers>::open(container, options)?))
    }

    fn bake(&self, job: &Job<'_>, output: &Path) -> Result<BakeReport> {
        layered::bake::<Self>(job, output)
    }
}

/// Whether nothing was set that kinds which keep surfaces as they are do not have.
pub(super) fn check_surfaces(settings: &Bake) -> Result<()> {
    layered::check(settings)?;
    if settings.resets.is_some() {
        return refuse("--resets", "mtsm");
    }
    if settings.tolerance.is_some() {
        return refuse("--tolerance", "deep, fragments or mtsm");
    }
    if settings.samples.is_some_and(|samples| samples != 1) {
        let kind = settings.kind.name();
        return Err(Error::Unsupported(format!("a map of kind {kind} has one sample a pixel")));
    }
    Ok(())
}

impl BakeFromBehind for Layers {
    fn bake_seen<T: Transmittance>(
        job: &Job<'_>,
        view: &ViewRaster,
        light_depth: f32,
        source: AnyHitSource<'_, T>,
        output: &Path,
    ) -> Result<BakeReport> {
        let mut settings = layered::settings(job, view, light_depth, 0.0)?;
        let times = job.settings.samples.unwrap_or(1);
        settings.bake.sampling = PixelSampling::centre_over_time(times, job.settings.seed)?;
        let baker = MultilayerBaker::<T, _>::new(source, settings)?;
        let describe = |metadata: &mut _| job.describe(metadata);
        let baked =
            bake_layers(&baker, output, job.settings.packing, describe, |at| job.watch(at))?;
        Ok(job.report::<T>(times, Tolerance::EXACT, baked))
    }
}
