//! Short rays near the receiver, lookups beyond.

use std::convert::Infallible;

use dsm_core::detail::Result;
use dsm_core::detail::random::{next_bits, unit};
use dsm_core::{
    AreaLight, Error, Facing, LightVisibility, OcclusionTracer, ShadedPoint, Transmittance,
};
use dsm_trace::detail::{LightFrame, LightMean};
use glam::DVec3;

use super::lookup::{LightCone, ReceiverPlane};
use super::shadow::PrefilteredShadow;
use super::source::PrefilteredSource;

/// How far short rays go unless another reach is set: to where the light's cone is so
/// many texels wide.
const REACH: f64 = 8.0;

/// Less light than this from beyond is worth no rays.
const DARK: f32 = 0.02;

/// How far behind the receiver fragments tell that something is near, in sides of a texel.
const BEHIND: f64 = 2.0;

/// The shadow factors of a prefiltered map beyond some reach, times those of short rays
/// through something exact: the last texels before a receiver are what no filter tells.
///
/// Rays are not traced where little light comes from beyond, or where no list of the map
/// has anything near.
#[derive(Debug)]
pub struct HybridShadow<M, N> {
    far: PrefilteredShadow<M>,
    near: N,
    rays: u32,
    reach: f64,
}

impl<M, N> HybridShadow<M, N>
where
    M: PrefilteredSource,
    N: OcclusionTracer<Value = M::Value, Error = Infallible>,
{
    /// 16 rays a receiver, to where the light's cone is eight texels wide.
    #[must_use]
    pub const fn new(far: PrefilteredShadow<M>, near: N) -> Self {
        Self { far, near, rays: 16, reach: REACH }
    }

    /// Sets the number of short rays of a receiver, at least 1: a square number of each
    /// part of the light.
    #[must_use]
    pub fn with_rays(self, rays: u32) -> Self {
        Self { rays: rays.max(1), ..self }
    }

    /// Sets how far short rays go: to where the light's cone is so many texels of level 0
    /// wide.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] unless it is finite and not negative.
    pub fn with_reach(self, texels: f64) -> Result<Self> {
        if !(0.0..f64::INFINITY).contains(&texels) {
            let reason = "it must be finite and not negative";
            return Err(Error::Setting { setting: "reach", reason });
        }
        Ok(Self { reach: texels, ..self })
    }

    /// The frame of the map.
    #[must_use]
    pub fn frame(&self) -> &LightFrame {
        self.far.frame()
    }

    fn factor(
        &self,
        lists: &M::Lists,
        point: &ShadedPoint,
        light: &AreaLight,
    ) -> Result<M::Value, M::Error> {
        let Some(receiver) = self.far.receiver(point, light) else { return Ok(M::Value::CLEAR) };
        let parts = self.far.parts(point, light);
        if parts.rate <= 0.0 {
            // The rays of a point end at no width.
            return Ok(self.whole(point, light));
        }
        let least = receiver.w + self.reach / parts.rate;
        let receiver = LightCone { least, ..self.far.on_its_surface(lists, receiver)? };
        let count = parts.counts[0] * parts.counts[1];
        let side = f64::from(self.rays / count).sqrt().round().max(1.0) as u32;
        let mut near_is_clear = None;
        let mut mean = LightMean::<M::Value>::new();
        for middle in parts.middles() {
            let Some(cone) = self.far.cone(&receiver, &parts, middle, point, light) else {
                mean.add(M::Value::CLEAR);
                continue;
            };
            let far = self.far.left(lists, &cone)?;
            let is_dark = (0..M::Value::CHANNELS).all(|channel| far.channel(channel) < DARK);
            let is_clear = match near_is_clear {
                _ if is_dark => true,
                Some(is_clear) => is_clear,
                None => *near_is_clear.insert(self.is_clear(lists, &cone, parts.counts)?),
            };
            if is_clear {
                mean.add(far);
                continue;
            }
            let size = parts.counts.map(|count| f64::from(count).recip());
            let corner = [0, 1].map(|axis| middle[axis] - size[axis] / 2.0);
            let cells = Cells { corner, size, side };
            let near = self.near(point, light, least, &cells);
            mean.add(M::Value::from_channels(|c| near.channel(c) * far.channel(c)));
        }
        Ok(mean.of(count))
    }

    /// True if the map shows nothing between a receiver and where rays end. What lies in
    /// the receiver's plane is nothing if the whole light, of so many parts, is seen above it.
    fn is_clear(
        &self,
        lists: &M::Lists,
        cone: &LightCone,
        parts: [u32; 2],
    ) -> Result<bool, M::Error> {
        let depth = cone.w.recip();
        let behind = (depth + BEHIND * self.frame().footprint(depth)).recip();
        // How fast the ray that is nearest to the plane falls towards it.
        let falls = |plane: ReceiverPlane| {
            let half = cone.rate * f64::from(parts[0].max(parts[1])) / 2.0;
            let of = |axis: usize| plane.slope[axis] * cone.slope[axis];
            of(0) + of(1) + half * (plane.slope[0].abs() + plane.slope[1].abs())
        };
        let is_above = cone.plane.is_some_and(|plane| plane.is_lit && falls(plane) < 0.9);
        // The cone, and the texel that a fragment may stand for.
        let radius = f64::from(parts[0].max(parts[1])) * self.reach / 2.0 + 0.75;
        let behind = (!is_above).then_some(behind);
        self.far.map().known().is_clear(lists, cone, radius, behind)
    }

    /// What short rays to some cells of the light leave, which end at `least`.
    fn near(&self, point: &ShadedPoint, light: &AreaLight, least: f64, cells: &Cells) -> M::Value {
        let from = self.frame().camera_point(point.position).z;
        let mut mean = LightMean::<M::Value>::new();
        let mut state = point.seed;
        for [u, v] in cells.places(&mut state) {
            let to = light.at(point.position, u, v);
            let to_depth = self.frame().camera_point(to).z;
            let share = ((least.recip() - from) / (to_depth - from)).clamp(0.0, 1.0);
            let end = if share.is_nan() { to } else { point.position.lerp(to, share) };
            let Ok(left) = self.near.transmittance(point.position, end, 0.5);
            mean.add(left);
        }
        mean.of(cells.side * cells.side)
    }

    /// What the whole ray to a point of the light leaves.
    fn whole(&self, point: &ShadedPoint, light: &AreaLight) -> M::Value {
        let to = light.at(point.position, 0.5, 0.5);
        let Ok(left) = self.near.transmittance(point.position, to, 0.5);
        left
    }
}

/// A part of a light in cells of which each has a ray.
struct Cells {
    corner: [f64; 2],
    size: [f64; 2],
    side: u32,
}

impl Cells {
    /// A place in each cell, in [0, 1]² of the light.
    fn places<'a>(&'a self, state: &'a mut u64) -> impl Iterator<Item = [f64; 2]> + 'a {
        (0..self.side * self.side).map(move |cell| {
            let jitter = [unit(next_bits(state)), unit(next_bits(state))];
            let at = [cell % self.side, cell / self.side];
            [0, 1].map(|axis| {
                let within = (f64::from(at[axis]) + jitter[axis]) / f64::from(self.side);
                (self.corner[axis] + self.size[axis] * within).clamp(0.0, 1.0)
            })
        })
    }
}

impl<M, N> LightVisibility for HybridShadow<M, N>
where
    M: PrefilteredSource,
    N: OcclusionTracer<Value = M::Value, Error = Infallible>,
{
    type Value = M::Value;
    type Error = M::Error;

    fn visibility(
        &self,
        receiver: DVec3,
        light: &AreaLight,
        seed: u64,
    ) -> Result<M::Value, M::Error> {
        let point = ShadedPoint { position: receiver, facing: Facing::Light, seed };
        self.far.map().with_lists(|lists| self.factor(lists, &point, light))
    }

    fn visibilities(
        &self,
        points: &[ShadedPoint],
        light: &AreaLight,
        values: &mut Vec<M::Value>,
    ) -> Result<(), M::Error> {
        self.far.map().with_lists(|lists| {
            for point in points {
                values.push(self.factor(lists, point, light)?);
            }
            Ok(())
        })
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::super::lists::FragmentLists;
    use super::super::map::PrefilteredMap;
    use super::super::settings::PrefilterSettings;
    use super::*;
    use crate::fragments::oracle::frame;

    /// Lets half of the light through, and counts rays.
    #[derive(Default)]
    struct Haze(AtomicU32);

    impl OcclusionTracer for &Haze {
        type Value = f32;
        type Error = Infallible;

        fn transmittance(&self, _: DVec3, to: DVec3, _: f64) -> Result<f32, Infallible> {
            self.0.fetch_add(1, Ordering::Relaxed);
            // Where the light's cone is 2 texels wide: f = l F (w - w_s), of l = 1 and F = 16.
            assert!((-to.z).recip() - 0.25 - 2.0 / 16.0 < 1e-9, "{to}");
            Ok(0.5)
        }
    }

    /// Fragments at this depth in the right half of the map.
    fn shadow(depth: f32) -> PrefilteredShadow<PrefilteredMap<f32>> {
        let mut lists = FragmentLists::new([32, 32]);
        for texel in 0..32 * 32 {
            if texel % 32 >= 16 {
                lists.push(depth.recip(), 1.0);
            }
            lists.finish_texel().unwrap();
        }
        let settings = PrefilterSettings::default();
        PrefilteredShadow::new(
            PrefilteredMap::new(frame([32, 32], 0.0), lists, &settings, 1.0).unwrap(),
        )
    }

    #[test]
    fn rays_end_where_lookups_begin() {
        let light = AreaLight::rectangle(DVec3::ZERO, DVec3::X / 2.0, DVec3::Y / 2.0);
        let lit = |shadow: &PrefilteredShadow<_>, x: f64, haze: &Haze| {
            let hybrid = HybridShadow::new(shadow.clone(), haze).with_rays(16);
            let hybrid = hybrid.with_reach(2.0).unwrap();
            let Ok(left) = hybrid.visibility(DVec3::new(x, 0.1, -4.0), &light, 1);
            left
        };
        // Far before the receiver, and seen from beside: no rays, and what lookups say.
        let (far, haze) = (shadow(1.5), Haze::default());
        let Ok(alone) = far.visibility(DVec3::new(0.1, 0.1, -4.0), &light, 1);
        assert!((0.2..0.8).contains(&alone), "{alone}");
        assert!((lit(&far, 0.1, &haze) - alone).abs() < 1e-5);
        assert_eq!(haze.0.load(Ordering::Relaxed), 0);
        // Near it: rays alone, as lookups begin behind.
        let (near, haze) = (shadow(3.5), Haze::default());
        assert_eq!(lit(&near, 1.0, &haze), 0.5);
        assert_eq!(haze.0.load(Ordering::Relaxed), 16);
        // Nothing near, on the other side.
        assert_eq!(lit(&near, -2.0, &haze), 1.0);
        assert_eq!(haze.0.load(Ordering::Relaxed), 16);
    }
}
