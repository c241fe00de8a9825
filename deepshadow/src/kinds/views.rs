//! Depth images from several points of a light (Agrawala, Ramamoorthi, Heirich & Moll 2000).

use std::ops::ControlFlow;
use std::path::Path;

use dsm_core::{Progress, Rgb, Tolerance, Transmittance, ViewRaster};
use dsm_io::detail::{Container, ErasedMap};
use dsm_io::{Limits, MergeReport, WriteOptions};
use dsm_trace::detail::CoherentShadow;
use shadow_maps::detail::{Views as ViewsKind, ViewsBuilder, ViewsTracer, view_points};

use super::layered;
use super::layers::check_surfaces;
use super::shadow_kind::{ShadowKind, join, refuse};
use crate::bake::Job;
use crate::bake::occluders::AnyHitSource;
use crate::bake::report::BakeReport;
use crate::bake::settings::{Bake, Channels};
use crate::error::{Error, Result};
use crate::file::open_options::OpenOptions;
use crate::file::{CachedFile, OpenMap};
use crate::merge::MergeSettings;
use crate::query::method::Method;
use crate::query::settings::Query;
use crate::query::trace_method::TraceMethod;
use crate::shadow::AreaShadow;
use crate::shadow::handle::Shadow;

/// Views unless another number is asked for: from the light's corners.
const VIEWS: u32 = 4;

/// What several points of a light see.
pub(super) struct Views;

impl ShadowKind for Views {
    fn check(&self, settings: &Bake) -> Result<()> {
        if settings.coverage.is_some() {
            return refuse("--coverage", "fragments");
        }
        if settings.max_layers.is_some() {
            return refuse("--layers", "fragments, layers, mtsm or prefiltered");
        }
        if settings.views == Some(0) {
            return Err(Error::Unsupported("there must be one view or more".to_owned()));
        }
        if settings.channels == Channels::Rgb {
            return Err(Error::Unsupported("a map of kind views has one channel".to_owned()));
        }
        check_surfaces(settings)
    }

    fn has_views(&self) -> bool {
        true
    }

    fn merge(
        &self,
        maps: Vec<Container>,
        limits: &Limits,
        output: &Path,
        settings: &mut MergeSettings<'_>,
    ) -> Result<MergeReport> {
        join::<ViewsKind>(maps, limits, output, settings)
    }

    fn open(&self, container: Container, options: &OpenOptions) -> Result<Box<dyn OpenMap>> {
        Ok(Box::new(CachedFile::<ViewsKind>::open(container, options)?))
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
    let mut builder =
        ViewsBuilder::new(view.shadow_camera(), asked.resolution)?.with_crop(job.crop());
    let light = builder.frame().area_light(job.extent);
    // Of a sphere the disk that the middle of the map sees.
    let before = light.centre() - view.basis().z_axis;
    let points = view_points(&light, before, asked.views.unwrap_or(VIEWS));
    let count = points.len() as u32;
    builder.check_count(count.into())?;
    let rows = u64::from(builder.rows());
    for (number, eye) in (0..).zip(points) {
        let view = view.at_eye(eye);
        let source = look(&view)?;
        let mut done = number * rows;
        let watch = || {
            let progress = Progress::new(done, rows * u64::from(count));
            done += 1;
            job.watch(progress)
        };
        let added = builder.add_view(&source, (eye, &view.shadow_camera()), watch);
        match added.map_err(|error| dsm_io::Error::HitSource(Box::new(error)))? {
            ControlFlow::Continue(()) => {}
            ControlFlow::Break(()) => return Err(Error::Interrupted),
        }
    }
    let options =
        WriteOptions::default().with_tile_size(asked.tile_size).with_packing(asked.packing);
    let baked = builder.write(output, options, |metadata| job.describe(metadata))?;
    Ok(job.report::<f32>(count, Tolerance::EXACT, baked))
}

impl OpenMap for CachedFile<ViewsKind> {
    fn file(&self) -> &dyn ErasedMap {
        self.reader()
    }

    fn default_method(&self) -> Method {
        TraceMethod::default().into()
    }

    fn shadow(&self, query: &Query) -> Result<Shadow> {
        let refuse = |reason| Err(Error::query(self.reader(), reason));
        // Of three channels there is none.
        let Self::Mono(map) = self else { return refuse("a map of views has one channel") };
        let tracer = ViewsTracer::read(map.reader())?;
        let method = match query.method.unwrap_or(self.default_method()) {
            Method::Trace(method) => method,
            Method::Coherence(method) => {
                let tracer = started(tracer.with_blockers(), method.start)?;
                let light = layered::light(query, map.reader(), tracer.frame())?;
                let shadow = CoherentShadow::new(tracer, method.settings(false));
                return Ok(Shadow::new(Box::new(AreaShadow(shadow)), light, query.seed));
            }
            _ => return refuse("views are traced: --method trace or coherence reads them"),
        };
        if method.has_layer_rules() || method.far_table.is_some() {
            return refuse(
                "views have surfaces alone; --rule, --z-threshold and --far-table are for maps of \
                 other kinds",
            );
        }
        let tracer = started(tracer.with_rays(method.rays), method.start)?;
        let light = layered::light(query, map.reader(), tracer.frame())?;
        Ok(Shadow::new(Box::new(AreaShadow(tracer)), light, query.seed))
    }
}

/// With a ray offset, if there is one.
fn started(tracer: ViewsTracer, start: Option<f64>) -> Result<ViewsTracer> {
    Ok(match start {
        Some(start) => tracer.with_start(start)?,
        None => tracer,
    })
}
