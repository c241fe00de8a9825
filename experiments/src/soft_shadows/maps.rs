//! The maps of a light, and the ways to make shadows of them.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;

use anyhow::Result;
use dsm_core::{AreaLight, ViewRaster};
use dsm_scene::{Light, Scene, SceneRasterizer};
use dsm_trace::detail::LightFrame;
use glam::DVec3;
use mtsm::detail::{
    FilteredLayers, LeafRule, MultilayerTracer, SoftPercentageCloser, TraceSettings,
};
use mtsm::{MultilayerBaker, MultilayerMap, MultilayerSettings};
use rayon::ThreadPoolBuilder;
use shadow_maps::detail::{
    FragmentBuilder, FragmentMap, FragmentTracer, ViewsBuilder, ViewsTracer, view_points,
};

use super::stage::Shadow;
use crate::figures::seconds;

/// A way to make soft shadows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Percentage closer filtering with eq. (1), of a map from the light's
    /// centre.
    Filter,
    /// Tracing one layer a pixel as the paper does.
    Single,
    /// Tracing 5 layers a pixel as the paper does: subtraction, a depth
    /// threshold.
    Paper,
    /// Tracing up to 32 layers a pixel by ratios, without a threshold.
    Ratio,
    /// Tracing planes with coverage masks.
    Fragments,
    /// Tracing depth images from the light's corners and its centre.
    Views,
}

impl Method {
    /// All that have a map from one place.
    pub const ALL: [Self; 5] =
        [Self::Filter, Self::Single, Self::Paper, Self::Ratio, Self::Fragments];

    /// Those and several views.
    pub const WITH_VIEWS: [Self; 6] =
        [Self::Filter, Self::Single, Self::Paper, Self::Ratio, Self::Fragments, Self::Views];

    /// As tables name it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Filter => "PCF",
            Self::Single => "K = 1, subtract",
            Self::Paper => "K = 5, subtract",
            Self::Ratio => "K = 32, ratio",
            Self::Fragments => "fragments",
            Self::Views => "5 views",
        }
    }

    /// The most layers of a pixel.
    const fn layers(self) -> u32 {
        match self {
            Self::Single => 1,
            Self::Paper => 5,
            _ => MultilayerSettings::MAX_LAYERS,
        }
    }
}

/// A map of one light for one method.
pub struct Map {
    /// The method.
    pub method: Method,
    /// Seconds of one processor to make it.
    pub seconds: f64,
    /// Its layers, of all pixels.
    pub layers: usize,
    kind: Kind,
}

enum Kind {
    /// With the side of a pixel at the light's target, in scene units.
    Layers {
        map: Arc<MultilayerMap<f32>>,
        pixel: f64,
    },
    Fragments(Arc<FragmentMap<f32>>),
    Views(Box<ViewsTracer>),
}

impl Map {
    /// Makes the map of a scene's light, `side` pixels wide. On one thread, so
    /// that its time is known.
    ///
    /// # Errors
    ///
    /// What the bakers say.
    pub fn new(scene: &Scene, light: &Light, method: Method, side: u32) -> Result<Self> {
        ThreadPoolBuilder::new().num_threads(1).build()?.install(|| {
            let start = Instant::now();
            let before = seconds(start);
            let kind = Kind::new(scene, light, method, side)?;
            let seconds = seconds(start) - before;
            let layers = match &kind {
                Kind::Layers { map, .. } => {
                    let pixels = map.pixels();
                    (0..pixels.pixel_count()).map(|pixel| pixels.falling_layers(pixel)).sum()
                }
                Kind::Fragments(map) => map.len(),
                Kind::Views(tracer) => {
                    let pixels = tracer.views().iter().flat_map(|view| view.w());
                    pixels.filter(|&&w| w > 0.0).count()
                }
            };
            Ok(Self { method, seconds, layers, kind })
        })
    }

    /// What a lighter sets by looking at the picture, as tried: of PCF the bias
    /// in scene units (0: a pixel's side), of the paper's tracing the depth
    /// threshold in sides of a pixel.
    pub(crate) const fn knobs(&self) -> &'static [f64] {
        match self.method {
            Method::Filter => &[0.0, 0.03, 0.1, 0.2, 0.4],
            Method::Single | Method::Paper => &[0.25, 1.0],
            Method::Ratio | Method::Fragments | Method::Views => &[0.0],
        }
    }

    /// A tracer of the layers, with the settings that suit most scenes; none of other maps.
    pub(crate) fn layers_tracer(&self) -> Result<Option<MultilayerTracer<MultilayerMap<f32>>>> {
        let Kind::Layers { map, .. } = &self.kind else { return Ok(None) };
        let tracer = MultilayerTracer::new(Arc::clone(map), TraceSettings::default())?;
        Ok(Some(tracer))
    }

    /// What `use_shadow` does with the shadows of the map, by `rays` light
    /// samples a point.
    ///
    /// # Errors
    ///
    /// What the tracers say.
    pub(crate) fn with_shadow<R>(
        &self,
        light: &AreaLight,
        rays: u32,
        knob: f64,
        use_shadow: impl FnOnce(&Shadow<'_>) -> R,
    ) -> Result<R> {
        let (map, pixel) = match &self.kind {
            Kind::Fragments(map) => {
                let tracer = FragmentTracer::new(Arc::clone(map))?.for_light(light);
                return Ok(use_shadow(&tracer.with_rays(rays)));
            }
            Kind::Views(tracer) => {
                return Ok(use_shadow(&ViewsTracer::clone(tracer).with_rays(rays)));
            }
            Kind::Layers { map, pixel } => (map, *pixel),
        };
        if self.method == Method::Filter {
            let filter =
                SoftPercentageCloser::new(Arc::clone(map), FilteredLayers::All)?.with_taps(rays)?;
            let filter =
                if knob > 0.0 { filter.with_bias(knob)? } else { filter.with_pixel_bias() };
            return Ok(use_shadow(&filter));
        }
        let mut settings = TraceSettings { rays, ..TraceSettings::default() };
        if self.method != Method::Ratio {
            (settings.rule, settings.depth_threshold) = (LeafRule::Subtract, knob * pixel);
        }
        Ok(use_shadow(&MultilayerTracer::new(Arc::clone(map), settings)?))
    }
}

impl Kind {
    fn new(scene: &Scene, light: &Light, method: Method, side: u32) -> Result<Self> {
        let raster = light.raster([side; 2])?;
        if method == Method::Views {
            // As the other paper has it: the corners, and the centre.
            let area = light.area()?;
            let mut points = view_points(&area, light.view.target, 4);
            points.push(area.centre());
            return Ok(Self::Views(views(scene, raster, points)?.into()));
        }
        let half = raster.half_size();
        // So that the map shows what any point of the light sees (eq. 4).
        let pushed = LightFrame::push_back(light.area()?.extent(), half.to_array());
        let back = if method == Method::Filter { 0.0 } else { f64::from(pushed as f32) };
        let raster = raster.moved_back(back);
        let source = SceneRasterizer::<f32>::new(scene, raster)?;
        let camera = raster.shadow_camera();
        if method == Method::Fragments {
            let builder = FragmentBuilder::new(camera, [side; 2], back)?;
            return Ok(Self::Fragments(builder.build(&source)?.into()));
        }
        let mut settings = MultilayerSettings::new([side; 2])?;
        settings.bake.camera = Some(camera);
        settings.max_layers = method.layers();
        settings.light_depth = back as f32;
        let map = MultilayerBaker::new(source, settings)?.map()?;
        let depth = (light.view.eye - light.view.target).length() + back;
        let pixel = 2.0 * depth * half.max_element() / f64::from(side);
        Ok(Self::Layers { map: map.into(), pixel })
    }
}

/// A tracer of what these points of a light see, through views as wide as `raster`.
///
/// # Errors
///
/// What a view is not.
pub(crate) fn views(
    scene: &Scene,
    raster: ViewRaster,
    points: impl IntoIterator<Item = DVec3>,
) -> Result<ViewsTracer> {
    let mut builder = ViewsBuilder::new(raster.shadow_camera(), raster.resolution())?;
    for eye in points {
        let view = raster.at_eye(eye);
        let source = SceneRasterizer::<f32>::new(scene, view)?;
        let seen = (eye, &view.shadow_camera());
        // Nobody breaks it off.
        let _ = builder.add_view(&source, seen, || ControlFlow::Continue(()))?;
    }
    Ok(builder.tracer()?)
}
