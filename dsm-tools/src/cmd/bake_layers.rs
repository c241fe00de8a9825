//! `bake` of layered maps.

use std::path::Path;

use anyhow::{Context, Result, bail};
use dsm_core::{BakeSettings, Rgb, Transmittance};
use dsm_io::{BakeReport, Metadata};
use dsm_scene::SceneRasterizer;
use dsm_trace::LightFrame;
use mtsm::{
    LayeredKind, LayeredReport, MultilayerBaker, MultilayerSettings, bake_fragments, bake_layers,
    bake_mtsm,
};
use shadow_maps::fragments::FragmentBuilder;

use super::bake::{BakeJob, Watch};
use crate::args::LayersRequest;

/// A scene and how its layered map is to be baked.
pub(crate) struct LayersJob<'a> {
    pub(crate) job: &'a BakeJob<'a>,
    pub(crate) layers: LayersRequest,
}

impl LayersJob<'_> {
    /// Bakes on the current pool. Also says of how many pixels layers were left
    /// out.
    pub(crate) fn run(&self, output: &Path) -> Result<(BakeReport, u64)> {
        let report = if self.job.is_coloured() {
            self.bake::<Rgb>(output)
        } else {
            self.bake::<f32>(output)
        }?;
        let LayeredReport { hits, cut_pixels, bytes } = report;
        Ok((BakeReport { hits, bytes }, cut_pixels))
    }

    fn bake<T: Transmittance>(&self, output: &Path) -> Result<LayeredReport> {
        let Self { job, layers } = *self;
        let LayersRequest { kind, max_layers, resets, coverage } = layers;
        let raster = job.scene.light.raster(job.settings.size)?;
        if !raster.is_perspective() {
            bail!("rays of an area light need a light with a perspective projection");
        }
        let light = job.scene.light.area()?.extent();
        // So that the map has all that any point of the light sees.
        let light_depth = LightFrame::push_back(light, raster.half_size().to_array()) as f32;
        let raster = raster.moved_back(light_depth.into());
        let source = SceneRasterizer::<T>::new(job.scene, raster)?;
        let block = job.options.block;
        let describe = |metadata: &mut Metadata| job.describe(light, metadata);
        if kind == LayeredKind::Fragments {
            let size = job.settings.size;
            let builder = FragmentBuilder::new(raster.shadow_camera(), size, light_depth.into())?
                .with_coverage(coverage)?
                .with_layers(max_layers)?;
            let tiles = (job.settings.tile_size, block);
            let baked = bake_fragments::<T, _>(&builder, &source, output, tiles, describe);
            return baked.with_context(|| format!("baking {}", job.name));
        }
        let camera = Some(raster.shadow_camera());
        let bake = BakeSettings { camera, ..job.settings.clone() };
        let settings = MultilayerSettings { bake, resets, max_layers, light_depth };
        let baker = MultilayerBaker::<T, _>::new(source, settings)?;
        let watch = Watch::start(job, baker.settings().bake.tile_count())?;
        let at = |progress| watch.at(progress);
        let done = match kind {
            LayeredKind::Mtsm => bake_mtsm(&baker, output, block, describe, at),
            _ => bake_layers(&baker, output, block, describe, at),
        };
        watch.bar.finish_and_clear();
        done.with_context(|| format!("baking {}", job.name))
    }
}
