//! What one point of a light sees, as the light's centre would.

use dsm_core::detail::Result;
use dsm_core::{
    Error, HitSource, PixelSampling, ShadowCamera, TileHits, TileSamples, Transmittance,
};
use dsm_trace::detail::LightFrame;
use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::warp::Warp;

/// Texels along the side of what is asked for at once.
pub(super) const TILE: u32 = 16;

/// How far a plane is followed from a hit to the middle of a texel, in sides of a texel
/// there: what is steeper hardly faces the light.
const STEEP: f64 = 4.0;

/// A view from a point of a light.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightView {
    camera: ShadowCamera,
    frame: LightFrame,
    warp: Warp,
    /// From its camera's space to that of the centre, without the offset.
    turn: DMat3,
}

/// A place that a view sees, where the light's centre has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Seen<T> {
    pub(super) place: [f64; 2],
    pub(super) w: f64,
    /// w of its plane per texel.
    pub(super) gradient: [f64; 2],
    /// What the view passes to it.
    pub(super) passed: T,
}

/// What a view sees in a row of tiles, tile by tile, and how many surfaces its rays met.
type SeenRow<T> = (Vec<Vec<Seen<T>>>, u64);

impl<T> Seen<T> {
    /// By how much more depths differ on its plane than across it, as far as that is
    /// followed.
    #[inline]
    pub(super) fn lean(&self, side: f64) -> f64 {
        let [x, y] = self.gradient;
        1.0_f64.hypot(x.hypot(y) / (side * self.w)).min(STEEP)
    }

    /// w of its plane in the middle of a texel, as far as that is followed: `side` is a
    /// texel's, as a share of the depth.
    #[inline]
    pub(super) fn w_at(&self, texel: [f64; 2], side: f64) -> f64 {
        let across = |axis: usize| self.gradient[axis] * (texel[axis] + 0.5 - self.place[axis]);
        let most = (STEEP * side * self.w).min(self.w / 2.0);
        self.w + (across(0) + across(1)).clamp(-most, most)
    }
}

impl LightView {
    /// The view of `camera`, of as many pixels as the map has.
    ///
    /// # Errors
    ///
    /// As [`LightFrame::new`].
    pub(super) fn new(
        camera: ShadowCamera,
        (centre, centre_frame): (&ShadowCamera, &LightFrame),
    ) -> Result<Self> {
        let frame = LightFrame::new(&camera, centre_frame.size(), 0.0)?;
        let warp = Warp::new((&camera, &frame), (centre, centre_frame))?;
        let turn = centre_frame.basis().transpose() * frame.basis();
        Ok(Self { camera, frame, warp, turn })
    }

    /// Whether a place of the centre's raster lies in the view's.
    pub(super) fn holds(&self, place: [f64; 3]) -> bool {
        let size = self.frame.size().map(f64::from);
        self.warp
            .back(place)
            .is_some_and(|[x, y, _]| (0.0..size[0]).contains(&x) && (0.0..size[1]).contains(&y))
    }

    /// What the view sees in the rows of tiles from `top` on, in the order of its pixels,
    /// of each the nearest first, and how many surfaces its rays met. In parallel.
    ///
    /// # Errors
    ///
    /// Those of the source; [`Error::Setting`] if it shows media.
    pub(super) fn row<T: Transmittance, S: HitSource<T>>(
        &self,
        source: &S,
        centre: &LightFrame,
        top: u32,
    ) -> std::result::Result<SeenRow<T>, S::Error> {
        let [width, height] = self.frame.size();
        let blocks: std::result::Result<Vec<_>, S::Error> = (0..width.div_ceil(TILE))
            .into_par_iter()
            .map_init(
                || TileHits::with_normals(0),
                |hits, column| {
                    let min = [column * TILE, top];
                    let size = [width - min[0], height - min[1]].map(|side| side.min(TILE));
                    self.block(source, centre, (min, size), hits)
                },
            )
            .collect();
        let blocks = blocks?;
        let met = blocks.iter().map(|(_, met)| met).sum();
        Ok((blocks.into_iter().map(|(seen, _)| seen).collect(), met))
    }

    fn block<T: Transmittance, S: HitSource<T>>(
        &self,
        source: &S,
        centre: &LightFrame,
        (min, size): ([u32; 2], [u32; 2]),
        hits: &mut TileHits<T>,
    ) -> std::result::Result<(Vec<Seen<T>>, u64), S::Error> {
        // Maps have at most 2²⁴ texels a side.
        let corner = min.map(|side| side as i32);
        let camera = Some((&self.camera, self.frame.size()));
        let samples = TileSamples::new(&PixelSampling::centre(), corner, size, camera)?;
        hits.reset(samples.len());
        source.hits(&samples, hits)?;
        if !hits.segments().is_empty() {
            let reason = "an attenuation map holds surfaces, no media";
            return Err(Error::Setting { setting: "scene", reason }.into());
        }
        let mut normals = hits.normals().iter().peekable();
        let mut met: Vec<(u32, f32, T, Option<DVec3>)> = Vec::with_capacity(hits.surface_count());
        for (index, (sample, hit)) in (0..).zip(hits.surfaces()) {
            let normal = normals.next_if(|(surface, _)| *surface == index);
            met.push((sample, hit.depth, hit.opacity, normal.map(|(_, n)| n.as_dvec3())));
        }
        // Those at one depth stay in the order of the source.
        met.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let (mut seen, count) = (Vec::with_capacity(met.len()), met.len() as u64);
        let (mut pixel, mut left) = (None, T::CLEAR);
        for (sample, depth, opacity, normal) in met {
            if pixel.replace(sample) != Some(sample) {
                left = T::CLEAR;
            }
            if depth > 0.0 && left != T::BLOCKED {
                let at = [sample % size[0], sample / size[0]];
                let place = [0, 1].map(|axis| f64::from(min[axis] + at[axis]) + 0.5);
                seen.extend(self.warped(place, depth, (left, normal), centre));
            }
            left = T::from_channels(|c| left.channel(c) * (1.0 - opacity.channel(c)));
        }
        Ok((seen, count))
    }

    /// A hit, as the light's centre has it.
    fn warped<T>(
        &self,
        [x, y]: [f64; 2],
        depth: f32,
        (passed, normal): (T, Option<DVec3>),
        centre: &LightFrame,
    ) -> Option<Seen<T>> {
        let [x, y, w] = self.warp.there([x, y, f64::from(depth).recip()])?;
        let plane = normal.and_then(|normal| centre.plane(x, y, w.recip(), self.turn * normal));
        let place = [x, y];
        let is_sound = x.is_finite() && y.is_finite() && w < f64::from(f32::MAX);
        let gradient = plane.unwrap_or_default();
        is_sound.then_some(Seen { place, w, gradient, passed })
    }
}
