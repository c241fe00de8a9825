//! Deep shadow maps (Lokovic & Veach 2000).

use std::path::Path;

use dsm_core::detail::Quantization;
use dsm_core::{BakeSettings, Baker, PixelSampling, Side, Tolerance, Transmittance, ViewRaster};
use dsm_io::detail::{BakeOptions, Container, ErasedMap};
use dsm_io::{Codec, ConvertOptions, Limits, MapReader, MergeReport, WriteOptions};

use super::shadow_kind::{ShadowKind, refuse};
use crate::bake::occluders::AnyHitSource;
use crate::bake::report::BakeReport;
use crate::bake::settings::Bake;
use crate::bake::{Job, Seen};
use crate::error::{Error, Result};
use crate::file::open_options::OpenOptions;
use crate::file::texel_hits::{self, TexelHits};
use crate::file::{CachedFile, OpenMap};
use crate::merge::MergeSettings;
use crate::query::filter_method::FilterMethod;
use crate::query::method::Method;
use crate::query::settings::Query;
use crate::shadow::filtered_shadow;
use crate::shadow::handle::Shadow;

/// Visibility functions, compressed within a bound.
pub(super) struct Deep;

impl ShadowKind for Deep {
    fn check(&self, settings: &Bake) -> Result<()> {
        if settings.max_layers.is_some() {
            return refuse("--layers", "fragments, layers, mtsm or prefiltered");
        }
        if settings.resets.is_some() {
            return refuse("--resets", "mtsm");
        }
        if settings.coverage.is_some() {
            return refuse("--coverage", "fragments");
        }
        if let Some(error) = settings.depth_error {
            if settings.codec != Codec::Quantized {
                let reason =
                    "--depth-error is for --codec quantized: others keep depths as they are";
                return Err(Error::Unsupported(reason.to_owned()));
            }
            Quantization::within(error)?;
        }
        if settings.target_size.is_some() && (settings.pyramid.is_some() || settings.crop.is_some())
        {
            let reason = "--target-size is for whole maps without --mip";
            return Err(Error::Unsupported(reason.to_owned()));
        }
        if let Some(compression) = settings.compression {
            compression.check()?;
            if compression.side == Side::Darker && settings.codec == Codec::Quantized {
                let reason = "--side darker is for --codec exact: the other moves depths away \
                              from the light, where the map is lighter";
                return Err(Error::Unsupported(reason.to_owned()));
            }
        }
        PixelSampling::new(settings.samples.unwrap_or(SAMPLES), settings.seed)?;
        Ok(())
    }

    fn merge(
        &self,
        maps: Vec<Container>,
        limits: &Limits,
        output: &Path,
        settings: &mut MergeSettings<'_>,
    ) -> Result<MergeReport> {
        let maps = maps.into_iter().map(|map| MapReader::new(map, limits));
        let maps = maps.collect::<std::result::Result<Vec<_>, _>>()?;
        Ok(dsm_io::merge(&maps, output, settings.tolerance, &mut *settings.watch)?)
    }

    fn open(&self, container: Container, options: &OpenOptions) -> Result<Box<dyn OpenMap>> {
        Ok(Box::new(CachedFile::<dsm_io::detail::Deep>::open(container, options)?))
    }

    fn bake(&self, job: &Job<'_>, output: &Path) -> Result<BakeReport> {
        let view = job.light.raster(job.settings.resolution)?;
        match job.look(&view)? {
            Seen::Mono(source) => bake(job, &view, source, output),
            Seen::Rgb(source) => bake(job, &view, source, output),
        }
    }
}

impl OpenMap for CachedFile<dsm_io::detail::Deep> {
    fn file(&self) -> &dyn ErasedMap {
        self.reader()
    }

    fn default_method(&self) -> Method {
        FilterMethod::POINT.into()
    }

    fn shadow(&self, query: &Query) -> Result<Shadow> {
        let Method::Filter(method) = query.method.unwrap_or(self.default_method()) else {
            let reason = "a deep map has no layers to trace or to filter over a light's outline: \
                          --method filter reads it";
            return Err(Error::query(self.reader(), reason));
        };
        match self {
            Self::Mono(map) => filtered_shadow(map, method, query),
            Self::Rgb(map) => filtered_shadow(map, method, query),
        }
    }

    fn texel_hits(&self) -> Option<Result<TexelHits>> {
        Some(match self {
            Self::Mono(map) => texel_hits::of_functions(map.reader()).map(TexelHits::Mono),
            Self::Rgb(map) => texel_hits::of_functions(map.reader()).map(TexelHits::Rgb),
        })
    }
}

/// Samples a pixel unless another number is asked for.
const SAMPLES: u32 = 16;

fn bake<T: Transmittance>(
    job: &Job<'_>,
    view: &ViewRaster,
    source: AnyHitSource<'_, T>,
    output: &Path,
) -> Result<BakeReport> {
    let asked = job.settings;
    let samples = asked.samples.unwrap_or(SAMPLES);
    let mut settings = BakeSettings::new(asked.resolution)?;
    settings.tile_size = asked.tile_size;
    settings.crop = asked.crop;
    settings.sampling = PixelSampling::new(samples, asked.seed)?;
    settings.filter = asked.filter;
    settings.tolerance = asked.tolerance;
    settings.camera = Some(view.shadow_camera());
    settings.quantization = job.quantization()?;
    settings.compression = asked.compression.unwrap_or_default();
    if let Some(bytes) = asked.target_size {
        return bake_to_size(job, settings, source, output, bytes);
    }
    let options = BakeOptions::default()
        .with_codec(asked.codec)
        .with_packing(asked.packing)
        .with_pyramid(asked.pyramid);
    let tolerance = settings.tolerance();
    let baker = Baker::<T, _>::new(source, settings)?;
    let describe = |metadata: &mut _| job.describe(metadata);
    let baked = dsm_io::detail::bake(&baker, output, &options, describe, |at| job.watch(at))?;
    Ok(job.report::<T>(samples, tolerance, baked))
}

/// What functions that are kept to be compressed are off, of the tolerance.
const KEPT_SHARE: f64 = 1.0 / 16.0;

/// Bakes functions that are nearly exact into a file beside `output`, and compresses those
/// under the smallest tolerance whose file keeps to a size.
fn bake_to_size<T: Transmittance>(
    job: &Job<'_>,
    settings: BakeSettings,
    source: AnyHitSource<'_, T>,
    output: &Path,
    bytes: u64,
) -> Result<BakeReport> {
    let (least, samples) = (settings.tolerance(), settings.sampling.samples_per_pixel());
    let spent = f64::from(least.epsilon()) * KEPT_SHARE;
    let options = ConvertOptions {
        tolerance: least.after(spent),
        write: WriteOptions::default()
            .with_tile_size(settings.tile_size)
            .with_codec(job.settings.codec)
            .with_packing(job.settings.packing),
        quantization: settings.quantization,
        compression: settings.compression,
        ..ConvertOptions::default()
    };
    let kept = Tolerance::new(spent as f32)?;
    let settings = settings.with_quantization(None).with_tolerance(kept);
    let baker = Baker::<T, _>::new(source, settings)?;
    let describe = |metadata: &mut _| job.describe(metadata);
    let watch = |at| job.watch(at);
    let (baked, stated) =
        dsm_io::detail::bake_to_size(&baker, output, &options, bytes, describe, watch)?;
    Ok(job.report::<T>(samples, stated, baked))
}
