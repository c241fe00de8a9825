//! Soft shadows by tracing maps of layers (Xie, Tabellion & Pearce 2007, §4.3
//! and §5.2).

use std::convert::Infallible;
use std::ops::ControlFlow;
use std::sync::Arc;

use dsm_core::{AreaLight, Error, LightVisibility, OcclusionTracer, Result, Transmittance};
use dsm_trace::{
    LightFrame, LightMean, MinMaxPyramid, ShadowRay, TraceCounters, TraceStatistics,
    walk_every_pixel, walk_pixels,
};
use glam::DVec3;

use crate::depth_layers::MultilayerDepthMap;
use crate::leaf_rule::{Interval, LeafRule, RayLight};
use crate::multilayer_map::MultilayerMap;
use crate::multilayer_settings::LayeredInfo;

/// How a map of layers is traced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TraceSettings {
    /// How layers that count several samples are taken apart.
    pub rule: LeafRule,
    /// How far a sample reaches in depth to either side, in scene units: the
    /// constant *z* threshold of §6.1. 0, the default, meets samples where they
    /// are, each in one pixel of the ray at most.
    pub depth_threshold: f64,
    /// The length at the receiver's end of a ray that meets nothing, in scene
    /// units. None, the default: the side of a pixel at the receiver's depth, and
    /// the threshold. Layers know a pixel's depth at its centre only, and so a
    /// lit surface needs as much not to shade itself.
    pub start: Option<f64>,
    /// Shadow rays of a light, at least 1.
    pub rays: u32,
    /// A ray ends when less than this is left of its light, in every channel.
    pub stop_below: f64,
}

impl Default for TraceSettings {
    /// The ratio rule, no threshold, 256 rays that end below 0.001.
    fn default() -> Self {
        Self {
            rule: LeafRule::Ratio,
            depth_threshold: 0.0,
            start: None,
            rays: 256,
            stop_below: 1e-3,
        }
    }
}

impl TraceSettings {
    fn check(&self) -> Result<()> {
        let refuse = |setting, reason| Err(Error::Setting { setting, reason });
        if self.rays == 0 {
            return refuse("rays", "there must be at least 1 a light");
        }
        if !(0.0..f64::INFINITY).contains(&self.depth_threshold) {
            return refuse("depth threshold", "it must be finite and not negative");
        }
        if self.start.is_some_and(|start| !(0.0..f64::INFINITY).contains(&start)) {
            return refuse("start", "it must be finite and not negative");
        }
        if !(0.0..=1.0).contains(&self.stop_below) {
            return refuse("stop", "it must lie between 0 and 1");
        }
        Ok(())
    }
}

mod sealed {
    use dsm_core::Transmittance;

    use crate::leaf_rule::{Interval, RayLight};

    /// The layers of a map's pixels, as a shadow ray meets them.
    pub trait Layers: Send + Sync {
        /// Mono or coloured.
        type Value: Transmittance;

        fn size(&self) -> [u32; 2];

        fn depth_range(&self, pixel: usize) -> Option<[f32; 2]>;

        /// What the first layer leaves at `depth`.
        fn behind_first(&self, pixel: usize, depth: f32) -> Self::Value;

        /// What all layers leave at `depth`, in the first run.
        fn behind_all(&self, pixel: usize, depth: f32) -> Self::Value;

        #[expect(private_interfaces, reason = "nobody else can name this trait")]
        fn pass(&self, pixel: usize, interval: &Interval, light: &mut RayLight<Self::Value>);

        /// The same without shortcuts.
        #[expect(private_interfaces, reason = "nobody else can name this trait")]
        fn pass_naively(
            &self,
            pixel: usize,
            interval: &Interval,
            light: &mut RayLight<Self::Value>,
        );
    }
}

/// A map of layers that shadow rays can be traced through: a [`MultilayerMap`] or
/// a [`MultilayerDepthMap`].
pub trait TracedMap: sealed::Layers {
    /// What the map says of itself.
    fn layered_info(&self) -> &LayeredInfo;
}

impl<T: Transmittance> TracedMap for MultilayerMap<T> {
    fn layered_info(&self) -> &LayeredInfo {
        self.info()
    }
}

impl<T: Transmittance> TracedMap for MultilayerDepthMap<T> {
    fn layered_info(&self) -> &LayeredInfo {
        self.info()
    }
}

impl<T: Transmittance> sealed::Layers for MultilayerMap<T> {
    type Value = T;

    fn size(&self) -> [u32; 2] {
        [self.pixels().width(), self.pixels().height()]
    }

    fn depth_range(&self, pixel: usize) -> Option<[f32; 2]> {
        self.pixels().depth_range(pixel)
    }

    fn behind_first(&self, pixel: usize, depth: f32) -> T {
        let first = self.pixels().first_run(pixel).and_then(|run| {
            let mut layers = run.layers().skip(1).filter(|layer| layer.visibility != T::CLEAR);
            layers.next()
        });
        let before = first.filter(|layer| layer.depth <= depth);
        before.map_or(T::CLEAR, |layer| layer.visibility)
    }

    fn behind_all(&self, pixel: usize, depth: f32) -> T {
        self.pixels().first_run(pixel).map_or(T::CLEAR, |run| run.function().at(depth))
    }

    #[expect(private_interfaces, reason = "nobody else can name this trait")]
    fn pass(&self, pixel: usize, interval: &Interval, light: &mut RayLight<T>) {
        self.pixels().runs(pixel).rev().for_each(|run| light.pass_run(run, interval));
    }

    #[expect(private_interfaces, reason = "nobody else can name this trait")]
    fn pass_naively(&self, pixel: usize, interval: &Interval, light: &mut RayLight<T>) {
        self.pixels().runs(pixel).rev().for_each(|run| light.pass_run_naively(run, interval));
    }
}

impl<T: Transmittance> sealed::Layers for MultilayerDepthMap<T> {
    type Value = T;

    fn size(&self) -> [u32; 2] {
        [self.pixels().width(), self.pixels().height()]
    }

    fn depth_range(&self, pixel: usize) -> Option<[f32; 2]> {
        self.pixels().depth_range(pixel)
    }

    fn behind_first(&self, pixel: usize, depth: f32) -> T {
        let first = self.pixels().layers(pixel).next().filter(|layer| layer.depth <= depth);
        first.map_or(T::CLEAR, |layer| layer.transmittance())
    }

    fn behind_all(&self, pixel: usize, depth: f32) -> T {
        self.pixels().transmittance(pixel, depth)
    }

    #[expect(private_interfaces, reason = "nobody else can name this trait")]
    fn pass(&self, pixel: usize, interval: &Interval, light: &mut RayLight<T>) {
        light.pass_layers(self.pixels().layers(pixel), interval);
    }

    #[expect(private_interfaces, reason = "nobody else can name this trait")]
    fn pass_naively(&self, pixel: usize, interval: &Interval, light: &mut RayLight<T>) {
        light.pass_layers(self.pixels().layers(pixel), interval);
    }
}

/// The frame of a map's light.
pub(crate) fn map_frame<M: TracedMap>(map: &M) -> Result<LightFrame> {
    let info = map.layered_info();
    let camera = info.map.camera.ok_or(Error::Camera("the map has none"))?;
    LightFrame::new(&camera, map.size(), f64::from(info.layering.light_depth))
}

/// One `f64` a channel of a map.
type Sum<M> = <<M as sealed::Layers>::Value as Transmittance>::Sum;

/// Traces shadow rays through a map of layers, hierarchically over its pixels
/// and with a perspective divide at leaves only.
///
/// A receiver that is no deeper than the light's centre, or whose place is not
/// finite, is lit; so is a ray where it leaves the map
/// ([`Self::statistics`] counts both). Lights may be of any size: what the map
/// does not show of one casts no shadow.
#[derive(Debug)]
pub struct MultilayerTracer<M> {
    map: Arc<M>,
    frame: LightFrame,
    pyramid: MinMaxPyramid,
    range: Option<[f32; 2]>,
    settings: TraceSettings,
    floor: f64,
    counters: TraceCounters,
}

impl<M: TracedMap> MultilayerTracer<M> {
    /// A tracer of `map`. O(pixels).
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] for settings out of range, [`Error::Camera`] if the map
    /// has no perspective camera.
    pub fn new(map: Arc<M>, settings: TraceSettings) -> Result<Self> {
        settings.check()?;
        let frame = map_frame(&*map)?;
        let ranges = |pixel| map.depth_range(pixel);
        let pyramid = MinMaxPyramid::of_depths(map.size(), settings.depth_threshold, ranges)?;
        let range = pyramid.range();
        let floor = f64::from(map.layered_info().map.tolerance.epsilon()) / 8.0;
        Ok(Self { map, frame, pyramid, range, settings, floor, counters: TraceCounters::default() })
    }

    /// The light's frame.
    #[must_use]
    pub const fn frame(&self) -> &LightFrame {
        &self.frame
    }

    /// The settings.
    #[must_use]
    pub const fn settings(&self) -> &TraceSettings {
        &self.settings
    }

    /// The depths of the map's pixels.
    #[must_use]
    pub const fn pyramid(&self) -> &MinMaxPyramid {
        &self.pyramid
    }

    /// What was asked so far.
    #[must_use]
    pub fn statistics(&self) -> TraceStatistics {
        self.counters.get()
    }

    /// The ray within the map; where it leaves that is counted.
    fn shadow_ray(
        &self,
        receiver: DVec3,
        light: DVec3,
        counted: &mut TraceStatistics,
    ) -> Option<ShadowRay> {
        counted.rays += 1;
        let start = self.settings.start.unwrap_or_else(|| {
            let depth = self.frame.camera_point(receiver).z;
            self.frame.footprint(depth) + self.settings.depth_threshold
        });
        let is_deeper = self.frame.camera_point(receiver).z > self.frame.light_depth();
        counted.beside += u64::from(!is_deeper);
        let ray = self.frame.ray(receiver, light, start)?;
        let clip = ray.clip(self.frame.size(), self.range?);
        counted.leaving += u64::from(clip.leaves);
        clip.ray
    }

    fn trace(&self, receiver: DVec3, light: DVec3, counted: &mut TraceStatistics) -> Sum<M> {
        let mut left = RayLight::<M::Value>::new(self.settings.rule, self.floor);
        if let Some(ray) = self.shadow_ray(receiver, light, counted) {
            let width = self.frame.size()[0] as usize;
            let _ = walk_pixels(&self.pyramid, &ray, &mut |[x, y]: [u32; 2], enter, leave| {
                let interval = Interval::new(enter, leave, self.settings.depth_threshold);
                self.map.pass(y as usize * width + x as usize, &interval, &mut left);
                if left.is_below(self.settings.stop_below) {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            });
        }
        left.left
    }

    /// What [`OcclusionTracer::transmittance`] answers, by a walk through every
    /// pixel that the ray crosses, one sample after the other, to its end: what
    /// the tracer is checked against. O(pixels of the map).
    #[must_use]
    pub fn transmittance_naively(&self, receiver: DVec3, light: DVec3) -> M::Value {
        let mut left = RayLight::<M::Value>::new(self.settings.rule, self.floor);
        if let Some(ray) = self.shadow_ray(receiver, light, &mut TraceStatistics::default()) {
            let size = self.frame.size();
            walk_every_pixel(size, &ray, &mut |[x, y]: [u32; 2], enter, leave| {
                let interval = Interval::new(enter, leave, self.settings.depth_threshold);
                let pixel = y as usize * size[0] as usize + x as usize;
                self.map.pass_naively(pixel, &interval, &mut left);
                ControlFlow::Continue(())
            });
        }
        M::Value::from_sum(left.left)
    }
}

impl<M: TracedMap> OcclusionTracer for MultilayerTracer<M> {
    type Value = M::Value;
    type Error = Infallible;

    fn transmittance(
        &self,
        receiver: DVec3,
        light: DVec3,
        _time: f64,
    ) -> std::result::Result<M::Value, Infallible> {
        let mut counted = TraceStatistics::default();
        let left = self.trace(receiver, light, &mut counted);
        self.counters.add(counted);
        Ok(M::Value::from_sum(left))
    }
}

impl<M: TracedMap> LightVisibility for MultilayerTracer<M> {
    type Value = M::Value;
    type Error = Infallible;

    fn visibility(
        &self,
        receiver: DVec3,
        light: &AreaLight,
        seed: u64,
    ) -> std::result::Result<M::Value, Infallible> {
        let mut counted = TraceStatistics::default();
        let mut mean = LightMean::<M::Value>::new();
        for point in light.samples(receiver, self.settings.rays, seed) {
            mean.add_sum(self.trace(receiver, point, &mut counted));
        }
        self.counters.add(counted);
        Ok(mean.of(self.settings.rays))
    }
}
