//! Layered maps of any kind and number of channels, as far as commands share
//! them.

use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, Result, bail};
use dsm_core::{AreaLight, LightExtent, LightShape, LightVisibility, Transmittance};
use dsm_io::{Container, Limits};
use dsm_trace::{LightFrame, TraceStatistics};
use mtsm::{
    FilteredLayers, LayeredKind, LayeredReader, LeafRule, MultilayerTracer, SoftPercentageCloser,
    TraceSettings, TracedMap,
};
use shadow_maps::fragments::FragmentTracer;

/// The layered map in a file; none if it is of another kind.
pub(crate) fn open(path: &Path) -> Result<Option<LayeredReader>> {
    let limits = Limits::default();
    let container = Container::open(path, &limits)?;
    if LayeredKind::from_name(&container.kind()?).is_none() {
        return Ok(None);
    }
    Ok(Some(LayeredReader::new(container, &limits)?))
}

/// How soft shadows are made of a layered map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum AreaMethod {
    /// Shadow rays through the layers.
    Trace {
        /// Of a light.
        rays: u32,
        /// The length at the receiver that meets nothing; none: the default rule.
        start: Option<f64>,
        /// Of maps whose layers are no fragments.
        layers: LayerRule,
    },
    /// Percentage closer filtering over the light's outline.
    Pcf {
        /// Of a light.
        taps: u32,
        /// Taken off the receiver's depth; none: a pixel's side there.
        bias: Option<f64>,
    },
}

/// How rays meet layers that have a depth alone; none: the default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct LayerRule {
    pub(crate) leaf: Option<LeafRule>,
    /// In scene units.
    pub(crate) depth_threshold: Option<f64>,
}

impl LayerRule {
    /// Whether anything but the default was asked for.
    pub(crate) const fn is_given(&self) -> bool {
        self.leaf.is_some() || self.depth_threshold.is_some()
    }
}

/// What is done with the soft shadows of a map, of any kind.
pub(crate) trait AreaVisitor {
    /// What comes of it.
    type Output;

    /// The light whose shadows they are.
    fn light(&self, frame: &LightFrame) -> Result<AreaLight>;

    /// Uses the shadows; `statistics` tells what they were asked.
    fn visit<V: AreaShadow>(self, shadow: &V) -> Result<Self::Output>;
}

/// Soft shadows of a layered map.
pub(crate) trait AreaShadow: LightVisibility<Error = std::convert::Infallible> {
    /// The light's frame.
    fn frame(&self) -> &dsm_trace::LightFrame;

    /// What was asked so far.
    fn statistics(&self) -> TraceStatistics;

    /// Whether optical depths of coarse pixels stand for what is far from a
    /// receiver; none where that is never so.
    fn has_far_table(&self) -> Option<bool> {
        None
    }
}

impl<M: TracedMap> AreaShadow for MultilayerTracer<M> {
    fn frame(&self) -> &dsm_trace::LightFrame {
        self.frame()
    }

    fn statistics(&self) -> TraceStatistics {
        self.statistics()
    }
}

impl<T: Transmittance> AreaShadow for FragmentTracer<T> {
    fn frame(&self) -> &dsm_trace::LightFrame {
        self.map().frame()
    }

    fn statistics(&self) -> TraceStatistics {
        self.statistics()
    }

    fn has_far_table(&self) -> Option<bool> {
        Some(self.has_far_table())
    }
}

impl<M: TracedMap> AreaShadow for SoftPercentageCloser<M> {
    fn frame(&self) -> &dsm_trace::LightFrame {
        self.frame()
    }

    fn statistics(&self) -> TraceStatistics {
        self.statistics()
    }
}

/// Reads a layered map whole and hands its soft shadows to `visitor`.
pub(crate) fn with_shadow<V: AreaVisitor>(
    reader: &LayeredReader,
    method: AreaMethod,
    visitor: V,
) -> Result<V::Output> {
    if reader.metadata().channels == 1 {
        with_channels::<f32, V>(reader, method, visitor)
    } else {
        with_channels::<dsm_core::Rgb, V>(reader, method, visitor)
    }
}

fn with_channels<T: Transmittance, V: AreaVisitor>(
    reader: &LayeredReader,
    method: AreaMethod,
    visitor: V,
) -> Result<V::Output> {
    let path = reader.container().path().unwrap_or(Path::new("")).display().to_string();
    match reader.kind() {
        LayeredKind::Mtsm => with_map(reader.multilayer_map::<T>()?, method, visitor, &path),
        LayeredKind::Layers => {
            with_map(reader.multilayer_depth_map::<T>()?, method, visitor, &path)
        }
        LayeredKind::Fragments => {
            let AreaMethod::Trace { rays, start, layers } = method else {
                bail!("{path}: fragments are traced; maps of kind layers or mtsm can be filtered");
            };
            if layers.is_given() {
                bail!(
                    "{path}: fragments have planes; --rule and --z-threshold are for maps of kind \
                     mtsm or layers"
                );
            }
            let map = reader.fragment_map::<T>()?;
            let light = visitor.light(map.frame())?;
            // Before the rest is set, so that map and light alone decide.
            let tracer = FragmentTracer::new(map).with_context(|| path.clone())?;
            let tracer = tracer.for_light(&light).with_rays(rays);
            visitor.visit(&match start {
                Some(start) => tracer.with_start(start, start),
                None => tracer,
            })
        }
        _ => bail!("{path}: maps of kind {} cannot be traced", reader.kind().name()),
    }
}

fn with_map<M: TracedMap, V: AreaVisitor>(
    map: M,
    method: AreaMethod,
    visitor: V,
    path: &str,
) -> Result<V::Output> {
    match method {
        AreaMethod::Trace { rays, start, layers } => {
            let default = TraceSettings::default();
            let settings = TraceSettings {
                rule: layers.leaf.unwrap_or(default.rule),
                depth_threshold: layers.depth_threshold.unwrap_or(default.depth_threshold),
                start,
                rays,
                ..default
            };
            let tracer =
                MultilayerTracer::new(Arc::new(map), settings).with_context(|| path.to_owned())?;
            visitor.visit(&tracer)
        }
        AreaMethod::Pcf { taps, bias } => {
            let filter = SoftPercentageCloser::new(Arc::new(map), FilteredLayers::All)
                .and_then(|filter| filter.with_taps(taps))
                .and_then(|filter| match bias {
                    Some(bias) => filter.with_bias(bias),
                    None => Ok(filter.with_pixel_bias()),
                })
                .with_context(|| path.to_owned())?;
            visitor.visit(&filter)
        }
    }
}

/// The light of a map with another size, if one is given.
pub(crate) fn light_extent(reader: &LayeredReader, size: Option<[f32; 2]>) -> Result<LightExtent> {
    let known = reader.metadata().info.light;
    let Some(size) = size else {
        return known.context("the map does not say what its light is: --light-size does");
    };
    let shape = match known.map(|light| light.shape) {
        _ if size == [0.0; 2] => LightShape::Point,
        None | Some(LightShape::Point) => LightShape::Rectangle,
        Some(shape) => shape,
    };
    if matches!(shape, LightShape::Disk | LightShape::Sphere) && size[0] != size[1] {
        bail!("--light-size: a disk or a sphere is as high as wide");
    }
    Ok(LightExtent { shape, size })
}
