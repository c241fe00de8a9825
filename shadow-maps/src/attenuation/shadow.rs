//! Soft shadows by lookups in attenuation maps.

use dsm_core::detail::Result;
use dsm_core::{AreaLight, Error, Facing, LightVisibility, ShadedPoint, Transmittance};
use dsm_trace::detail::LightFrame;
use glam::DVec3;

use super::side::share_above;
use super::source::{AttenuationSource, TexelLists};
use crate::prefilter::lists::FragmentList;

/// The default bias, in sides of a texel at the receiver.
const BIAS: f64 = 2.0;

/// How far a receiver's plane is followed to the middle of a texel, in sides of a texel.
const STEEP: f64 = 4.0;

/// The shadow factors of an attenuation map (Agrawala et al. 2000, §4, `Display`): no
/// rays, one list of layers, or four.
///
/// A point has the attenuation of the nearest layer of its texel that lies within a depth
/// bias, and 0 where there is none: nothing of the light was seen there. So receivers are
/// what the map was made of; a point in the air is dark. Of points on surfaces the tangent
/// plane tells how deep layers ought to be in the middle of a texel, and no more of the light
/// reaches them than lies above it: a leaf that is seen from behind is dark, though the map
/// cannot tell its sides apart. Receivers beside the light, outside the map or at NaN are lit.
/// Of the light that a caller names only that side is asked: the shadows are those of the
/// light that the map was made from.
#[derive(Clone, Debug)]
pub struct AttenuationShadow<M> {
    map: M,
    /// In scene units; None: by the texels.
    bias: Option<f64>,
    bilinear: bool,
}

/// A point, as the map has it.
struct Place {
    at: [f64; 2],
    w: f64,
    /// w of its plane per texel.
    gradient: [f64; 2],
    depth: f64,
    bias: f64,
}

/// What a texel says of a point.
enum Answer<T> {
    /// A layer within the bias.
    Layer(T),
    /// Everything there lies before the point: it is dark.
    Dark,
    /// Light goes past the point's depth, or nothing is there: what is shaded ends before
    /// this texel.
    Beside,
}

impl<M: AttenuationSource> AttenuationShadow<M> {
    /// The shadows of `map`, of one texel each.
    #[must_use]
    pub const fn new(map: M) -> Self {
        Self { map, bias: None, bilinear: false }
    }

    /// Sets the depth bias in scene units. Unless it is set, it is two sides of a texel at
    /// the point.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] unless it is finite and not negative.
    pub fn with_bias(self, bias: f64) -> Result<Self> {
        if !(0.0..f64::INFINITY).contains(&bias) {
            let reason = "it must be finite and not negative";
            return Err(Error::Setting { setting: "bias", reason });
        }
        Ok(Self { bias: Some(bias), ..self })
    }

    /// Sets whether four texels are looked up and interpolated, against blocks in what is
    /// nearer to the eye than to the light (§6.3, figure 11). A texel without a layer in
    /// the bias counts as dark if all that it holds lies before the point, and not at all
    /// if light goes past the point there or the texel is empty; a point with no texel
    /// that counts is dark.
    #[must_use]
    pub fn with_bilinear(self, bilinear: bool) -> Self {
        Self { bilinear, ..self }
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

    fn place(&self, point: &ShadedPoint) -> Option<Place> {
        let frame = self.map.frame();
        let place = frame.project(point.position)?;
        let size = frame.size().map(f64::from);
        let is_inside = (0.0..size[0]).contains(&place.x) && (0.0..size[1]).contains(&place.y);
        let depth = frame.camera_point(point.position).z;
        let gradient = match point.facing {
            Facing::Surface(normal) => {
                frame.plane(place.x, place.y, depth, frame.basis().transpose() * normal)
            }
            _ => None,
        };
        let gradient = gradient.unwrap_or_default();
        // Across a slope the same distance is a greater one in depth.
        let slope = gradient[0].hypot(gradient[1]) / (frame.footprint(1.0) * place.z);
        let lean = 1.0_f64.hypot(slope).min(STEEP);
        let bias = self.bias.unwrap_or(BIAS * lean * frame.footprint(depth));
        let at = [place.x, place.y];
        is_inside.then_some(Place { at, w: place.z, gradient, depth, bias })
    }

    /// The shadow factor of one point.
    fn factor(
        &self,
        lists: &M::Lists,
        point: &ShadedPoint,
        light: &AreaLight,
    ) -> Result<M::Value, M::Error> {
        let Facing::Surface(normal) = point.facing else { return self.looked_up(lists, point) };
        let share = share_above(light, point.position, normal);
        if share <= 0.0 {
            return Ok(M::Value::BLOCKED);
        }
        let found = self.looked_up(lists, point)?;
        Ok(M::Value::from_channels(|c| found.channel(c).min(share as f32)))
    }

    /// What the map says of a point.
    fn looked_up(&self, lists: &M::Lists, point: &ShadedPoint) -> Result<M::Value, M::Error> {
        let Some(place) = self.place(point) else { return Ok(M::Value::CLEAR) };
        let side = self.map.frame().footprint(1.0);
        if !self.bilinear {
            // Inside, so not negative.
            let texel = place.at.map(|at| at as u32);
            return lists.with_list(texel, |list| match place.answer(list, texel, side) {
                Answer::Layer(share) => share,
                _ => M::Value::BLOCKED,
            });
        }
        let last = self.map.frame().size().map(|size| f64::from(size - 1));
        let first = place.at.map(|at| (at - 0.5).floor());
        let share = [0, 1].map(|axis| place.at[axis] - 0.5 - first[axis]);
        let (mut sum, mut all) = (M::Value::BLOCKED.to_sum(), 0.0);
        for (down, right) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let weight =
                |axis: usize, far: u8| if far == 1 { share[axis] } else { 1.0 - share[axis] };
            let weight = weight(0, right) * weight(1, down);
            let texel = [first[0] + f64::from(right), first[1] + f64::from(down)];
            // At the edges of the map those within it count.
            let is_inside = (0..2).all(|axis| (0.0..=last[axis]).contains(&texel[axis]));
            if weight <= 0.0 || !is_inside {
                continue;
            }
            let texel = texel.map(|at| at as u32);
            lists.with_list(texel, |list| match place.answer(list, texel, side) {
                Answer::Layer(found) => {
                    all += weight;
                    for (sum, found) in sum.as_mut().iter_mut().zip(found.to_sum().as_ref()) {
                        *sum += weight * found;
                    }
                }
                Answer::Dark => all += weight,
                Answer::Beside => {}
            })?;
        }
        if all <= 0.0 {
            return Ok(M::Value::BLOCKED);
        }
        Ok(M::Value::from_channels(|c| (sum.as_ref()[c] / all).clamp(0.0, 1.0) as f32))
    }
}

impl Place {
    /// What a texel says, whose side at depth 1 is `side`.
    fn answer<T: Transmittance>(
        &self,
        list: FragmentList<'_, T>,
        texel: [u32; 2],
        side: f64,
    ) -> Answer<T> {
        let across =
            |axis: usize| self.gradient[axis] * (f64::from(texel[axis]) + 0.5 - self.at[axis]);
        let most = (STEEP * side * self.w).min(self.w / 2.0);
        let w = self.w + (across(0) + across(1)).clamp(-most, most);
        let depth = if w == self.w { self.depth } else { w.recip() };
        let (mut found, mut least, mut beyond) = (None, self.bias, false);
        for (&w, &share) in list.w.iter().zip(list.opacities) {
            let off = f64::from(w).recip() - depth;
            if off.abs() <= least {
                (found, least) = (Some(share), off.abs());
            }
            beyond |= off > self.bias;
        }
        match found {
            Some(share) => Answer::Layer(share),
            None if beyond || list.w.is_empty() => Answer::Beside,
            None => Answer::Dark,
        }
    }
}

impl<M: AttenuationSource> LightVisibility for AttenuationShadow<M> {
    type Value = M::Value;
    type Error = M::Error;

    fn visibility(&self, receiver: DVec3, _: &AreaLight, seed: u64) -> Result<M::Value, M::Error> {
        let point = ShadedPoint { position: receiver, facing: Facing::Light, seed };
        self.map.with_lists(|lists| self.looked_up(lists, &point))
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
