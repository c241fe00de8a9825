//! Soft shadows by tracing maps of layers (Xie, Tabellion & Pearce 2007, §4.3
//! and §5.2).

use std::ops::ControlFlow;
use std::sync::Arc;

use dsm_core::detail::Occlusion;
use dsm_core::{
    AreaLight, Error, Facing, LightVisibility, OcclusionTracer, ShadedPoint, Transmittance,
};
use dsm_trace::detail::{
    LightFrame, LightMean, MinMaxBuilder, TraceCounters, TraceStatistics, walk_every_pixel,
};
use dsm_trace::{MinMaxPyramid, ShadowRay, walk_pixels};
use glam::DVec3;

use crate::layers_of_pixel::PixelLayers;
use crate::leaf_rule::{Interval, LeafRule, RayLight};
use crate::traced_map::sealed::{Layers, PixelReader};
use crate::traced_map::{TracedMap, map_frame};

/// Settings of tracing a map of layers.
///
/// ```
/// use mtsm::detail::{LeafRule, TraceSettings};
///
/// let settings = TraceSettings { rays: 64, ..TraceSettings::default() };
/// assert_eq!((settings.rule, settings.start), (LeafRule::Ratio, None));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TraceSettings {
    /// The rule by which layers that count several samples are split.
    pub rule: LeafRule,
    /// The reach of a sample in depth to either side, in scene units: the
    /// constant *z* threshold of §6.1. 0, the default, meets samples where they
    /// are, each in one pixel of the ray at most.
    pub depth_threshold: f64,
    /// The ray offset: the length at the receiver's end that meets nothing, in scene
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
    fn check(&self) -> dsm_core::detail::Result<()> {
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

/// One `f64` a channel of a map.
type Sum<M> = <<M as Layers>::Value as Transmittance>::Sum;

/// Traces shadow rays through a map of layers, hierarchically over its pixels
/// and with a perspective divide at leaves only.
///
/// A receiver that is no deeper than the light's centre, or whose place is not
/// finite, is lit; so is a ray where it leaves the map
/// ([`Self::statistics`] counts both). Lights may be of any size: what the map
/// does not show of one casts no shadow.
///
/// ```
/// use std::sync::Arc;
///
/// use dsm_core::{AreaLight, Error, LightVisibility, RayHits, RaySource, SamplePoint, SurfaceHit};
/// use glam::DVec3;
/// use mtsm::detail::{MultilayerTracer, TraceSettings};
/// use mtsm::{MultilayerBaker, MultilayerSettings};
///
/// # let to_ndc = glam::DMat4::from_cols(
/// #     glam::DVec4::new(0.5, 0.0, 0.0, 0.0),
/// #     glam::DVec4::new(0.0, -0.5, 0.0, 0.0),
/// #     glam::DVec4::new(-0.5, -0.5, -1.0, -1.0),
/// #     glam::DVec4::ZERO,
/// # );
/// # let camera = dsm_core::ShadowCamera {
/// #     world_to_camera: Some(glam::DMat4::IDENTITY),
/// #     world_to_ndc: Some(to_ndc),
/// # };
/// // An opaque half plane at depth 2, right of the camera's axis.
/// let source = RaySource(|point: SamplePoint, ray: &mut RayHits<f32>| -> Result<(), Error> {
///     if point.x > 32.0 {
///         ray.push_surface(SurfaceHit { depth: 2.0, opacity: 1.0 })?;
///     }
///     Ok(())
/// });
/// let mut settings = MultilayerSettings::new([64, 64])?;
/// settings.bake.camera = Some(camera);
/// let map = MultilayerBaker::new(source, settings)?.map()?;
/// let tracer = MultilayerTracer::new(Arc::new(map), TraceSettings::default())?;
/// let light = AreaLight::rectangle(DVec3::ZERO, DVec3::X * 0.5, DVec3::Y * 0.5);
/// // Straight behind the edge, half of the light is seen.
/// let Ok(half) = tracer.visibility(DVec3::new(0.0, 0.0, -4.0), &light, 0);
/// assert!((half - 0.5).abs() < 0.05);
/// # Ok::<(), Error>(())
/// ```
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
    /// A tracer of `map`. O(pixels); of a map behind a cache it reads every tile
    /// once, and holds one.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] for settings out of range, [`Error::Camera`] if the map
    /// has no perspective camera; what is wrong with a tile of a file.
    pub fn new(map: Arc<M>, settings: TraceSettings) -> Result<Self, M::BuildError> {
        settings.check()?;
        let frame = map_frame(&*map)?;
        let mut ranges = MinMaxBuilder::new(map.size())?;
        let threshold = settings.depth_threshold;
        map.depth_ranges(|pixel, depths| ranges.set_depths(pixel, depths, threshold))?;
        let pyramid = ranges.finish();
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

    /// Counts of the rays traced so far.
    #[must_use]
    pub fn statistics(&self) -> TraceStatistics {
        self.counters.get()
    }

    /// Where a ray starts: by a pixel beyond what its receiver lies on; if it goes through
    /// that, as it is on the side that is turned from the light, before it, by as much as
    /// its layers may lie deeper in their pixels.
    fn start(&self, receiver: DVec3, light: DVec3, facing: Facing) -> f64 {
        let point = self.frame.camera_point(receiver);
        let side = self.frame.footprint(point.z) + self.settings.depth_threshold;
        let Facing::Surface(normal) = facing else { return side };
        if (light - receiver).dot(normal) >= 0.0 {
            return side;
        }
        let slope = self.frame.project(receiver).and_then(|place| {
            let normal = self.frame.basis().transpose() * normal;
            self.frame.plane(place.x, place.y, point.z, normal)
        });
        let [x, y] = slope.unwrap_or([0.0; 2]).map(f64::abs);
        // Half a pixel to either side; no more than the depth that there is.
        let deeper = (0.5 * (x + y) * point.z * point.z).min(0.5 * point.z);
        let away = self.frame.camera_point(light) - point;
        -(side + deeper * away.length() / away.z.abs().max(f64::MIN_POSITIVE))
    }

    /// The ray within the map; where it leaves that is counted.
    fn shadow_ray(
        &self,
        receiver: DVec3,
        light: DVec3,
        facing: Facing,
        counted: &mut TraceStatistics,
    ) -> Option<ShadowRay> {
        counted.rays += 1;
        let start = self.settings.start.unwrap_or_else(|| self.start(receiver, light, facing));
        let is_deeper = self.frame.camera_point(receiver).z > self.frame.light_depth();
        counted.behind_light += u64::from(!is_deeper);
        let ray = self.frame.ray(receiver, light, start)?;
        let clip = ray.clip(self.frame.size(), self.range?);
        counted.outside_map += u64::from(clip.leaves);
        clip.ray
    }

    fn trace(
        &self,
        pixels: &M::Reader<'_>,
        [receiver, light]: [DVec3; 2],
        facing: Facing,
        counted: &mut TraceStatistics,
    ) -> Result<(Sum<M>, Option<DVec3>), M::Error> {
        let mut left = RayLight::<M::Value>::new(self.settings.rule, self.floor);
        let (mut failed, mut met) = (None, None);
        if let Some(ray) = self.shadow_ray(receiver, light, facing, counted) {
            let _ = walk_pixels(&self.pyramid, &ray, &mut |pixel: [u32; 2], enter, leave| {
                let interval = Interval::new(enter, leave, self.settings.depth_threshold);
                let before = left.left;
                let passed =
                    pixels.with_pixel(pixel, |of, pixel| of.pass(pixel, &interval, &mut left));
                failed = passed.err();
                if left.left != before {
                    met = Some((ray, 0.5 * (enter + leave)));
                }
                if failed.is_some() || left.is_below(self.settings.stop_below) {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            });
        }
        let blocker = met.map(|(ray, w)| {
            let [x, y] = ray.at(w);
            self.frame.unproject(x, y, w.recip())
        });
        failed.map_or(Ok((left.left, blocker)), Err)
    }

    /// The result of [`OcclusionTracer::transmittance`], by a walk through every
    /// pixel that the ray crosses, one sample after the other, to its end: what
    /// the tracer is checked against. O(pixels of the map).
    ///
    /// # Errors
    ///
    /// What is wrong with a tile of a file.
    pub fn transmittance_naively(
        &self,
        receiver: DVec3,
        light: DVec3,
    ) -> Result<M::Value, M::Error> {
        let mut left = RayLight::<M::Value>::new(self.settings.rule, self.floor);
        let (pixels, mut failed) = (self.map.reader(), None);
        let mut counted = TraceStatistics::default();
        if let Some(ray) = self.shadow_ray(receiver, light, Facing::Light, &mut counted) {
            let size = self.frame.size();
            walk_every_pixel(size, &ray, &mut |pixel: [u32; 2], enter, leave| {
                let interval = Interval::new(enter, leave, self.settings.depth_threshold);
                let passed = pixels
                    .with_pixel(pixel, |of, pixel| of.pass_naively(pixel, &interval, &mut left));
                failed = failed.take().or(passed.err());
                ControlFlow::Continue(())
            });
        }
        failed.map_or_else(|| Ok(M::Value::from_sum(left.left)), Err)
    }
}

impl<M: TracedMap> OcclusionTracer for MultilayerTracer<M> {
    type Value = M::Value;
    type Error = M::Error;

    fn transmittance(
        &self,
        receiver: DVec3,
        light: DVec3,
        _time: f64,
    ) -> Result<M::Value, M::Error> {
        let mut counted = TraceStatistics::default();
        let left = self.trace(&self.map.reader(), [receiver, light], Facing::Light, &mut counted);
        self.counters.add(counted);
        left.map(|(left, _)| M::Value::from_sum(left))
    }

    /// Blockers are places in a pixel whose layers took light, where the ray crosses it.
    fn occlusions(
        &self,
        receiver: &ShadedPoint,
        targets: &[(DVec3, f64)],
        found: &mut Vec<Occlusion<M::Value>>,
    ) -> Result<(), M::Error> {
        let pixels = self.map.reader();
        let mut counted = TraceStatistics::default();
        let traced = targets.iter().try_for_each(|&(light, _)| {
            let ends = [receiver.position, light];
            let (left, blocker) = self.trace(&pixels, ends, receiver.facing, &mut counted)?;
            found.push(Occlusion { transmittance: M::Value::from_sum(left), blocker });
            Ok(())
        });
        self.counters.add(counted);
        traced
    }
}

impl<M: TracedMap> LightVisibility for MultilayerTracer<M> {
    type Value = M::Value;
    type Error = M::Error;

    fn visibility(
        &self,
        receiver: DVec3,
        light: &AreaLight,
        seed: u64,
    ) -> Result<M::Value, M::Error> {
        self.visibility_of(&ShadedPoint { position: receiver, facing: Facing::Light, seed }, light)
    }

    fn visibilities(
        &self,
        points: &[ShadedPoint],
        light: &AreaLight,
        values: &mut Vec<M::Value>,
    ) -> Result<(), M::Error> {
        points.iter().try_for_each(|point| {
            values.push(self.visibility_of(point, light)?);
            Ok(())
        })
    }
}

impl<M: TracedMap> MultilayerTracer<M> {
    fn visibility_of(
        &self,
        &ShadedPoint { position, facing, seed }: &ShadedPoint,
        light: &AreaLight,
    ) -> Result<M::Value, M::Error> {
        let pixels = self.map.reader();
        let mut counted = TraceStatistics::default();
        let mut mean = LightMean::<M::Value>::new();
        let mut points = light.samples(position, self.settings.rays, seed);
        let traced = points.try_for_each(|point| {
            mean.add_sum(self.trace(&pixels, [position, point], facing, &mut counted)?.0);
            Ok(())
        });
        self.counters.add(counted);
        traced.map(|()| mean.of(self.settings.rays))
    }
}
