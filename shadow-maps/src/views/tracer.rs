//! Shadow rays through the depth images of several points of a light.

use std::convert::Infallible;

use dsm_core::detail::{Occlusion, Result};
use dsm_core::{AreaLight, Error, Facing, LightVisibility, OcclusionTracer, ShadedPoint};
use dsm_trace::detail::{LightFrame, LightMean};
use glam::DVec3;

use super::depth_view::DepthView;
use super::in_view::{InView, length, trace_part};
use super::interval::Interval;
use super::options::TraceOptions;
use super::trace::Walk;

/// How far from its receiver a ray starts, in sides of a pixel of the view there.
const START: f64 = 1.0;

/// How far along a ray it is blocked by the surface that it starts on: little, so that other
/// points see that to another side.
const OWN_SURFACE: f64 = 1.0 / 1024.0;

/// More than shares of rays are rounded by, relative.
const ROUNDING: f64 = 1.0 / (1 << 30) as f64;

/// A tracer of depth images (Agrawala et al. 2000, §5.1): a ray is blocked if it is in any
/// of them, of which each is asked for what those before it do not see.
///
/// Surfaces are opaque. What no view sees is lit, and so are receivers beside the light. Rays
/// start off their receivers, so that of a surface that is told the rays to its other side are
/// not traced, but blocked.
///
/// ```
/// use dsm_core::{AreaLight, LightVisibility, Projection, View};
/// use dsm_trace::detail::LightFrame;
/// use glam::DVec3;
/// use shadow_maps::detail::{DepthView, ViewsTracer};
///
/// let view = View { eye: DVec3::ZERO, target: DVec3::NEG_Z, up: DVec3::Y };
/// let view = view.raster(Projection::Perspective { fov: 90.0 }, [32, 32])?;
/// let frame = LightFrame::new(&view.shadow_camera(), [32, 32], 0.0)?;
/// // A half plane at depth 2: the right half of the image.
/// let w = (0..32 * 32).map(|pixel| if pixel % 32 >= 16 { 0.5 } else { 0.0 }).collect();
/// let views = vec![DepthView::new(frame, w, DepthView::GAP)?];
/// let tracer = ViewsTracer::new(views)?.with_rays(64);
/// let light = AreaLight::rectangle(DVec3::ZERO, DVec3::X / 4.0, DVec3::Y / 4.0);
/// let left = tracer.visibility(DVec3::new(0.0, 0.0, -4.0), &light, 0).unwrap();
/// assert!((left - 0.5).abs() < 0.1, "{left}");
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct ViewsTracer {
    views: Vec<DepthView>,
    frame: LightFrame,
    options: TraceOptions,
    rays: u32,
    /// In scene units; None: by the pixels.
    start: Option<f64>,
}

/// What a ray met.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayFate {
    /// Whether it is blocked.
    pub blocked: bool,
    /// Views that were asked.
    pub views: u32,
    /// Pixels and nodes that were looked at.
    pub steps: u64,
}

/// What is kept from ray to ray, so that none makes room anew.
#[derive(Debug, Default)]
struct Scratch {
    rays: Vec<InView>,
    /// What no view has seen yet, as shares of the ray, before and after one.
    unseen: [Vec<Interval>; 2],
    /// Where the ray passes behind something, in w.
    behind: Vec<Interval>,
    /// The same with what lies outside.
    hidden: Vec<Interval>,
}

impl ViewsTracer {
    /// The most pixels of all views together: some 5 GB of them and their quadtrees.
    pub const MAX_PIXELS: u64 = 1 << 28;

    /// Whether `count` views of `size` pixels are no more than that.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`].
    pub(super) fn check_pixels(size: [u32; 2], count: u64) -> Result<()> {
        let pixels = size.into_iter().map(u64::from).fold(count, u64::saturating_mul);
        let limit = Self::MAX_PIXELS;
        if pixels > limit {
            return Err(Error::TooLarge { what: "pixels of all views", count: pixels, limit });
        }
        Ok(())
    }

    /// A tracer of these views, with all accelerations and 64 rays a point.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] without views.
    pub fn new(views: Vec<DepthView>) -> Result<Self> {
        let Some(first) = views.first() else {
            let reason = "there must be one or more";
            return Err(Error::Setting { setting: "views", reason });
        };
        let frame = *first.frame();
        Ok(Self { views, frame, options: TraceOptions::ALL, rays: 64, start: None })
    }

    /// Sets which accelerations are used.
    #[must_use]
    pub fn with_options(self, options: TraceOptions) -> Self {
        Self { options, ..self }
    }

    /// Tells of every ray where it is blocked: without connectedness, which does not know.
    #[must_use]
    pub fn with_blockers(self) -> Self {
        let options = TraceOptions { connectedness: false, ..self.options };
        Self { options, ..self }
    }

    /// Sets the number of rays of a point, at least 1.
    #[must_use]
    pub fn with_rays(self, rays: u32) -> Self {
        Self { rays: rays.max(1), ..self }
    }

    /// Sets how far from a point its rays start, in scene units. Unless it is set, it is
    /// the side of a pixel there.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] unless it is finite and not negative.
    pub fn with_start(self, start: f64) -> Result<Self> {
        if !(0.0..f64::INFINITY).contains(&start) {
            let reason = "it must be finite and not negative";
            return Err(Error::Setting { setting: "ray offset", reason });
        }
        Ok(Self { start: Some(start), ..self })
    }

    /// Sets the frame of the light's centre; otherwise it is that of the first view.
    #[must_use]
    pub fn with_frame(self, frame: LightFrame) -> Self {
        Self { frame, ..self }
    }

    /// The frame of the map.
    #[must_use]
    pub const fn frame(&self) -> &LightFrame {
        &self.frame
    }

    /// The views.
    #[must_use]
    pub fn views(&self) -> &[DepthView] {
        &self.views
    }

    /// Traces the ray from a receiver to a point of the light.
    #[must_use]
    pub fn trace(&self, receiver: DVec3, light: DVec3) -> RayFate {
        self.trace_with(receiver, light, &mut Scratch::default()).0
    }

    /// What the ray met, and where it is blocked, if that is known.
    fn trace_with(
        &self,
        receiver: DVec3,
        light: DVec3,
        scratch: &mut Scratch,
    ) -> (RayFate, Option<DVec3>) {
        let mut fate = RayFate::default();
        let Scratch { rays, unseen: [unseen, left], behind, hidden } = scratch;
        rays.clear();
        let views = 0..self.views.len();
        rays.extend(views.filter_map(|view| self.in_view(view, receiver, light)));
        if self.options.ranking {
            rays.sort_by(|a, b| a.length.total_cmp(&b.length));
        }
        // Nearer to the light no view shows anything, though rasters end there.
        let end = rays.iter().map(|ray| self.end(ray)).fold(0.0, f64::max);
        let whole = [[0.0, end]];
        unseen.clear();
        unseen.extend(whole);
        for ray in rays.iter() {
            let parts = if self.options.intervals { &unseen[..] } else { &whole[..] };
            fate.views += 1;
            left.clear();
            for &part in parts {
                let mut walk = Walk::new(&self.views[ray.view], self.options, behind);
                let blocked = trace_part(ray, part, &mut walk, (hidden, left));
                fate.steps += walk.steps;
                if blocked {
                    fate.blocked = true;
                    let place = |w: f64| {
                        let [x, y] = ray.ray.at(w);
                        self.views[ray.view].frame().unproject(x, y, w.recip())
                    };
                    return (fate, walk.met.map(place));
                }
            }
            if self.options.clear_miss && left.is_empty() {
                return (fate, None);
            }
            std::mem::swap(unseen, left);
        }
        (fate, None)
    }

    /// The greatest w that a view shows.
    fn nearest(&self, view: usize) -> Option<f64> {
        self.views[view].ranges.range().map(|[_, high]| f64::from(high))
    }

    /// How far along a ray a view shows anything.
    fn end(&self, ray: &InView) -> f64 {
        self.nearest(ray.view).map_or(0.0, |w| ray.share(w * (1.0 + ROUNDING)))
    }

    /// A ray in a view; `None` where it sees none of it.
    fn in_view(&self, view: usize, receiver: DVec3, light: DVec3) -> Option<InView> {
        let frame = self.views[view].frame();
        let ends = [receiver, light].map(|point| frame.camera_point(point).z);
        let start = self.start.unwrap_or(START * frame.footprint(ends[0]));
        let ray = frame.ray(receiver, light, start)?;
        let inside = ray.crossing([0; 2], frame.size());
        let length = if self.options.ranking {
            length(&ray, inside, self.nearest(view).unwrap_or(0.0))
        } else {
            0.0
        };
        Some(InView { view, ray, inside, ends, length })
    }
}

impl ViewsTracer {
    /// The shadow factor of a point, of whose light no more counts than lies above its
    /// surface.
    fn factor(&self, point: &ShadedPoint, light: &AreaLight, scratch: &mut Scratch) -> f32 {
        let mut mean = LightMean::<f32>::new();
        for sample in light.samples(point.position, self.rays, point.seed) {
            mean.add(self.occlusion(point, sample, scratch).transmittance);
        }
        mean.of(self.rays)
    }

    /// What a ray met; nothing if it goes to the other side of the point's surface.
    fn occlusion(
        &self,
        point: &ShadedPoint,
        light: DVec3,
        scratch: &mut Scratch,
    ) -> Occlusion<f32> {
        let is_below = match point.facing {
            Facing::Surface(normal) => (light - point.position).dot(normal) <= 0.0,
            _ => false,
        };
        if is_below {
            // The surface itself blocks it, where the point is.
            let blocker = Some(point.position.lerp(light, OWN_SURFACE));
            return Occlusion { transmittance: 0.0, blocker };
        }
        let (fate, blocker) = self.trace_with(point.position, light, scratch);
        Occlusion { transmittance: if fate.blocked { 0.0 } else { 1.0 }, blocker }
    }
}

impl OcclusionTracer for ViewsTracer {
    type Value = f32;
    type Error = Infallible;

    fn transmittance(&self, receiver: DVec3, light: DVec3, _: f64) -> Result<f32, Infallible> {
        let point = ShadedPoint { position: receiver, facing: Facing::Light, seed: 0 };
        Ok(self.occlusion(&point, light, &mut Scratch::default()).transmittance)
    }

    fn occlusions(
        &self,
        receiver: &ShadedPoint,
        targets: &[(DVec3, f64)],
        found: &mut Vec<Occlusion<f32>>,
    ) -> Result<(), Infallible> {
        let mut scratch = Scratch::default();
        let targets = targets.iter().map(|&(light, _)| light);
        found.extend(targets.map(|light| self.occlusion(receiver, light, &mut scratch)));
        Ok(())
    }
}

impl LightVisibility for ViewsTracer {
    type Value = f32;
    type Error = Infallible;

    fn visibility(&self, receiver: DVec3, light: &AreaLight, seed: u64) -> Result<f32, Infallible> {
        let point = ShadedPoint { position: receiver, facing: Facing::Light, seed };
        Ok(self.factor(&point, light, &mut Scratch::default()))
    }

    fn visibilities(
        &self,
        points: &[ShadedPoint],
        light: &AreaLight,
        values: &mut Vec<f32>,
    ) -> Result<(), Infallible> {
        let mut scratch = Scratch::default();
        values.extend(points.iter().map(|point| self.factor(point, light, &mut scratch)));
        Ok(())
    }
}
