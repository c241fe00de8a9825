//! 16 shadow rays of one receiver.

use dsm_core::Transmittance;
use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, f32x16, mask32x16, u32x16};
use glam::DVec3;

use crate::LightFrame;
use crate::range_tree::{Cone, LANES};

/// The point that rays start at, in the frame of a light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Apex {
    pub(crate) place: [f32; 2],
    pub(crate) w: f32,
    /// In camera space, with the depth for z.
    point: DVec3,
}

/// How far from a receiver a ray starts: for planes, and for what faces the
/// camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Starts {
    /// In lengths of the ray.
    Shares([f64; 2]),
    /// In scene units along it.
    Distances([f64; 2]),
}

impl Starts {
    /// In lengths of a ray of this length.
    #[inline(always)]
    fn shares(self, length: f64) -> [f64; 2] {
        match self {
            Self::Shares(shares) => shares,
            Self::Distances([plane, facing]) => [plane / length, facing / length],
        }
    }
}

/// 16 rays from an apex as columns: u is the gain of w since the apex. Lanes
/// without a ray end before they start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Packet {
    /// Pixels per unit of u.
    pub(crate) slope: [[f32; LANES]; 2],
    /// From where on planes count, and what faces the camera.
    pub(crate) start: [[f32; LANES]; 2],
    pub(crate) end: [f32; LANES],
    /// Lanes that leave the raster at the depths of the map.
    pub(crate) leaving: u32,
    pub(crate) cone: Cone,
}

impl Apex {
    /// `None` where nothing can shade a receiver: no deeper than the light's
    /// centre, or not finite.
    pub(crate) fn new(frame: &LightFrame, receiver: DVec3) -> Option<Self> {
        let place = frame.project(receiver)?;
        let point = frame.camera_point(receiver);
        let apex = Self { place: [place.x as f32, place.y as f32], w: place.z as f32, point };
        let finite = apex.place.iter().all(|at| at.is_finite()) && apex.w.is_finite();
        (finite && point.z > frame.light_depth()).then_some(apex)
    }
}

impl Packet {
    /// The rays to up to 16 points of the light.
    #[inline(always)]
    pub(crate) fn new(
        frame: &LightFrame,
        apex: &Apex,
        lights: &[DVec3],
        starts: Starts,
        range: [f32; 2],
    ) -> Self {
        // Columns of f64, so that this is computed lane by lane at once.
        let mut to = [[f64::NAN; LANES]; 3];
        for (lane, &light) in lights.iter().take(LANES).enumerate() {
            let point = frame.camera_point(light);
            [to[0][lane], to[1][lane], to[2][lane]] = point.to_array();
        }
        let from = apex.point;
        let (linear, offset) = frame.raster_map();
        let place = linear * (from.truncate() / from.z) + offset;
        let w = from.z.recip();
        let most = f64::from(range[1]).next_up() - w;
        let mut slope = [[0.0; LANES]; 2];
        let mut start = [[0.0; LANES]; 2];
        let mut end = [0.0; LANES];
        for lane in 0..LANES {
            let (x, y, z) = (to[0][lane], to[1][lane], to[2][lane]);
            let away = [x - from.x, y - from.y, z - from.z];
            let length = (away[0] * away[0] + away[1] * away[1] + away[2] * away[2]).sqrt();
            // Pixels per unit of w; finite for points in the camera's plane too.
            let scale = (1.0 - w * z).recip();
            let along_x = linear.x_axis.x * x + linear.y_axis.x * y + (offset.x - place.x) * z;
            let along_y = linear.x_axis.y * x + linear.y_axis.y * y + (offset.y - place.y) * z;
            slope[0][lane] = (along_x * scale) as f32;
            slope[1][lane] = (along_y * scale) as f32;
            // 1/z(t) − 1/z(0) at share t of the way.
            let gain = |share: f64| {
                let gained = -share * away[2] * w;
                gained / (from.z + share * away[2])
            };
            let shares = starts.shares(length);
            start[0][lane] = gain(shares[0].min(1.0)) as f32;
            start[1][lane] = gain(shares[1].min(1.0)) as f32;
            let light = if z > 0.0 { z.recip() - w } else { f64::INFINITY };
            let reach = light.min(most);
            // Lights that are no nearer to the camera shade nothing.
            end[lane] = if away[2] < 0.0 && shares[0] < 1.0 { reach as f32 } else { -1.0 };
        }
        let least = (f64::from(range[0]) - w) as f32;
        Self::finish(frame.size(), apex, slope, start, end, least)
    }

    #[inline(always)]
    fn finish(
        size: [u32; 2],
        apex: &Apex,
        mut slope: [[f32; LANES]; 2],
        start: [[f32; LANES]; 2],
        mut end: [f32; LANES],
        least: f32,
    ) -> Self {
        let mut cone = Cone::empty(apex.place, apex.w);
        let mut leaving = 0;
        for lane in 0..LANES {
            let first = start[0][lane].min(start[1][lane]).max(least);
            let finite = slope[0][lane].is_finite() && slope[1][lane].is_finite();
            if !(finite && first <= end[lane]) {
                (slope[0][lane], slope[1][lane], end[lane]) = (0.0, 0.0, -1.0);
                continue;
            }
            let mut ray = Cone { near: first, far: end[lane], ..cone };
            let mut outside = false;
            for axis in 0..2 {
                let along = slope[axis][lane];
                ray.slopes[axis] = [along; 2];
                for u in [first, end[lane]] {
                    let at = apex.place[axis] + along * u;
                    outside |= !(at >= 0.0 && at <= size[axis] as f32);
                }
            }
            leaving |= u32::from(outside) << lane;
            cone.include(&ray);
        }
        Self { slope, start, end, leaving, cone }
    }
}

/// A packet as vectors, and what is left of its light.
#[derive(Clone, Copy)]
pub(crate) struct Lanes<S: Simd> {
    pub(crate) slope: [f32x16<S>; 2],
    pub(crate) start: [f32x16<S>; 2],
    pub(crate) end: f32x16<S>,
    /// Light that is left, a channel each.
    pub(crate) left: [f32x16<S>; 3],
}

impl<S: Simd> Lanes<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, packet: &Packet) -> Self {
        let load = |column: &[f32; LANES]| f32x16::load_array_ref(simd, column);
        Self {
            slope: [load(&packet.slope[0]), load(&packet.slope[1])],
            start: [load(&packet.start[0]), load(&packet.start[1])],
            end: load(&packet.end),
            left: [f32x16::splat(simd, 1.0); 3],
        }
    }

    /// Which rays meet a fragment of the pixel `beyond` which the apex lies, in
    /// pixels: `distance` is how much more w its plane has at the apex than it.
    ///
    /// No product is fused with a sum: all processors round alike.
    #[inline(always)]
    pub(crate) fn meet(
        &self,
        simd: S,
        beyond: [f32; 2],
        distance: f32,
        gradient: [f32; 2],
        facing: bool,
        coverage: u64,
    ) -> mask32x16<S> {
        let splat = |value| f32x16::splat(simd, value);
        let [along_x, along_y] = self.slope;
        let closing = splat(1.0) - (along_x * gradient[0] + along_y * gradient[1]);
        let u = splat(distance) / closing;
        // In eighths of the pixel.
        let x = (along_x * u + beyond[0]) * 8.0;
        let y = (along_y * u + beyond[1]) * 8.0;
        let (zero, eight) = (splat(0.0), splat(8.0));
        let within = x.simd_ge(zero) & x.simd_lt(eight) & y.simd_ge(zero) & y.simd_lt(eight);
        let start = self.start[usize::from(facing)];
        let met = within & u.simd_ge(start) & u.simd_lt(self.end);
        if coverage == u64::MAX || met.to_bitmask() == 0 {
            return met;
        }
        let (x, y): (u32x16<S>, u32x16<S>) = (x.to_int(), y.to_int());
        let bit = (y << 3) | x;
        let upper = bit.simd_ge(u32x16::splat(simd, 32));
        let (low, high) = (coverage as u32, (coverage >> 32) as u32);
        let word = upper.select(u32x16::splat(simd, high), u32x16::splat(simd, low));
        let covered = (word >> (bit & 31)) & 1;
        met & covered.simd_eq(u32x16::splat(simd, 1))
    }

    /// Takes the share `opacity` of each channel from the light of the rays in `met`.
    #[inline(always)]
    pub(crate) fn take<T: Transmittance>(
        &mut self,
        met: mask32x16<S>,
        opacity: impl Fn(usize) -> f32,
    ) {
        for channel in 0..T::CHANNELS {
            let left = self.left[channel];
            self.left[channel] = met.select(left * (1.0 - opacity(channel)), left);
        }
    }

    /// Puts out the light that fell below `least` in every channel, and ends
    /// those rays. Tells whether all have ended.
    #[inline(always)]
    pub(crate) fn stop<T: Transmittance>(&mut self, simd: S, least: f32) -> bool {
        let limit = f32x16::splat(simd, least);
        let mut dark = self.left[0].simd_lt(limit);
        for channel in 1..T::CHANNELS {
            dark &= self.left[channel].simd_lt(limit);
        }
        let zero = f32x16::splat(simd, 0.0);
        for channel in 0..T::CHANNELS {
            self.left[channel] = dark.select(zero, self.left[channel]);
        }
        self.end = dark.select(f32x16::splat(simd, -1.0), self.end);
        self.end.simd_gt(zero).to_bitmask() == 0
    }
}
