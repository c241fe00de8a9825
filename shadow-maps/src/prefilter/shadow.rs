//! Soft shadows by lookups in prefiltered maps.

use dsm_core::detail::Result;
use dsm_core::{AreaLight, Error, Facing, LightVisibility, ShadedPoint, Transmittance};
use dsm_trace::detail::{LightFrame, LightMean};
use glam::DVec3;

use super::accumulate::Accumulate;
use super::light_parts::{LightParts, slope};
use super::lookup::{LightCone, ReceiverPlane};
use super::own_plane::own_plane;
use super::source::PrefilteredSource;

/// The default bias, in sides of a texel at the receiver: fitted on leaves, a knot and
/// hair, of which none has the same best.
const BIAS: f64 = 1.2;

/// How far off a receiver's plane its own surface may be, in sides of a texel.
const PLANE_BIAS: f64 = 0.25;

/// Rounding of w, of which receivers and fragments have some each.
const ROUNDING: f64 = 1.0 / (1 << 21) as f64;

/// The shadow factors of a prefiltered map (Selgrad et al. 2014, §5): no rays, a few
/// lists of each level.
///
/// Of points on surfaces, fragments below the tangent plane are passed over where it
/// faces the light; where it faces away, the surface itself shades. Others take a depth
/// bias. Receivers beside the light, outside the map or at NaN are lit.
#[derive(Clone, Debug)]
pub struct PrefilteredShadow<M> {
    map: M,
    accumulate: Accumulate,
    /// In scene units; None: by the texels.
    bias: Option<f64>,
    splits: u32,
}

impl<M: PrefilteredSource> PrefilteredShadow<M> {
    /// The shadows of `map`: what fragments leave is multiplied, the light is as many
    /// parts as make it square.
    #[must_use]
    pub const fn new(map: M) -> Self {
        Self { map, accumulate: Accumulate::Multiply, bias: None, splits: 1 }
    }

    /// Sets the accumulation of opacities along a list and over levels.
    #[must_use]
    pub fn with_accumulate(self, accumulate: Accumulate) -> Self {
        Self { accumulate, ..self }
    }

    /// Sets the depth bias in scene units, for all points.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] unless it is finite.
    pub fn with_bias(self, bias: f64) -> Result<Self> {
        if !bias.is_finite() {
            return Err(Error::Setting { setting: "bias", reason: "it must be finite" });
        }
        Ok(Self { bias: Some(bias), ..self })
    }

    /// Sets the number of parts along the light's shorter side, at least 1: each is
    /// looked up by itself, and their mean is taken.
    #[must_use]
    pub fn with_splits(self, splits: u32) -> Self {
        Self { splits: splits.clamp(1, 64), ..self }
    }

    /// The frame of the map.
    #[must_use]
    pub fn frame(&self) -> &LightFrame {
        self.map.frame()
    }

    /// The map.
    #[must_use]
    pub const fn map(&self) -> &M {
        &self.map
    }

    /// The shadow factor of one point.
    fn factor(
        &self,
        lists: &M::Lists,
        point: &ShadedPoint,
        light: &AreaLight,
    ) -> Result<M::Value, M::Error> {
        let Some(receiver) = self.receiver(point, light) else { return Ok(M::Value::CLEAR) };
        let receiver = self.on_its_surface(lists, receiver)?;
        let parts = self.parts(point, light);
        let (mut mean, mut count) = (LightMean::<M::Value>::new(), 0);
        for middle in parts.middles() {
            count += 1;
            mean.add(match self.cone(&receiver, &parts, middle, point, light) {
                Some(cone) => self.left(lists, &cone)?,
                None => M::Value::CLEAR,
            });
        }
        Ok(mean.of(count))
    }

    /// The same on the surface that the map shows where a receiver without one is, if it
    /// shows one; it is taken to face the light.
    pub(super) fn on_its_surface(
        &self,
        lists: &M::Lists,
        receiver: LightCone,
    ) -> Result<LightCone, M::Error> {
        if receiver.plane.is_some() || self.bias.is_some() {
            return Ok(receiver);
        }
        let depth = receiver.w.recip();
        let side = self.map.frame().footprint(depth) / (depth * depth);
        let size = self.map.frame().size();
        let slope = own_plane(lists, size, receiver.place, receiver.w, side)?;
        let plane = slope.map(|slope| {
            let steep = slope[0].abs().max(slope[1].abs());
            let offset = PLANE_BIAS * (side + steep) + ROUNDING * receiver.w;
            ReceiverPlane { slope, offset, is_lit: true }
        });
        let start = plane.map_or(receiver.start, |plane| receiver.w + plane.offset);
        Ok(LightCone { plane, start, ..receiver })
    }

    /// The parts that a light is looked up in.
    pub(super) fn parts(&self, point: &ShadedPoint, light: &AreaLight) -> LightParts {
        LightParts::new(self.map.frame(), point.position, light, self.splits)
    }

    /// A part of a light as a receiver sees it; `None` where nothing of the map can lie
    /// between.
    pub(super) fn cone(
        &self,
        receiver: &LightCone,
        parts: &LightParts,
        [u, v]: [f64; 2],
        point: &ShadedPoint,
        light: &AreaLight,
    ) -> Option<LightCone> {
        let centre = light.at(point.position, u, v);
        let slope = slope(self.map.frame(), point.position, centre)?;
        Some(LightCone { slope, rate: parts.rate, ..*receiver })
    }

    /// What the map leaves of the light of a part.
    pub(super) fn left(&self, lists: &M::Lists, cone: &LightCone) -> Result<M::Value, M::Error> {
        self.map.known().visibility(lists, cone, self.accumulate)
    }

    /// The receiver in the frame of the map; `None` if it is lit, whatever the map holds.
    pub(super) fn receiver(&self, point: &ShadedPoint, light: &AreaLight) -> Option<LightCone> {
        let frame = self.map.frame();
        let place = frame.project(point.position)?;
        let depth = frame.camera_point(point.position).z;
        let size = frame.size().map(f64::from);
        let is_inside = (0.0..size[0]).contains(&place.x) && (0.0..size[1]).contains(&place.y);
        if !is_inside || depth <= frame.light_depth() {
            return None;
        }
        let w = place.z;
        let place = [place.x, place.y];
        let plane = self.plane(point, light, place, depth);
        // In w, as much as in depth at the receiver.
        let bias = self.bias.unwrap_or(BIAS * frame.footprint(depth));
        let start = match plane {
            Some(plane) => w + plane.offset,
            None if bias < depth => (depth - bias).recip(),
            None => return None,
        };
        Some(LightCone { place, w, start, least: 0.0, slope: [0.0; 2], rate: 0.0, plane })
    }

    /// The plane of the surface that a point lies on, unless a bias is set.
    fn plane(
        &self,
        point: &ShadedPoint,
        light: &AreaLight,
        place: [f64; 2],
        depth: f64,
    ) -> Option<ReceiverPlane> {
        let Facing::Surface(normal) = point.facing else { return None };
        if self.bias.is_some() {
            return None;
        }
        let frame = self.map.frame();
        let of_camera = frame.basis().transpose() * normal;
        let slope = frame.plane(place[0], place[1], depth, of_camera)?;
        let is_lit = normal.dot(light.centre() - point.position) > 0.0;
        let off = (PLANE_BIAS * frame.footprint(depth) / depth + ROUNDING) / depth;
        Some(ReceiverPlane { slope, offset: if is_lit { off } else { -off }, is_lit })
    }
}

impl<M: PrefilteredSource> LightVisibility for PrefilteredShadow<M> {
    type Value = M::Value;
    type Error = M::Error;

    fn visibility(
        &self,
        receiver: DVec3,
        light: &AreaLight,
        seed: u64,
    ) -> Result<M::Value, M::Error> {
        let point = ShadedPoint { position: receiver, facing: Facing::Light, seed };
        self.map.with_lists(|lists| self.factor(lists, &point, light))
    }

    fn visibilities(
        &self,
        points: &[ShadedPoint],
        light: &AreaLight,
        values: &mut Vec<M::Value>,
    ) -> Result<(), M::Error> {
        self.map.with_lists(|lists| {
            for point in points {
                values.push(self.factor(lists, point, light)?);
            }
            Ok(())
        })
    }
}
