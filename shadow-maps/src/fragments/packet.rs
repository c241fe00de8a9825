//! 16 shadow rays of one receiver.

use dsm_trace::detail::LightFrame;
use fearless_simd::{Select, Simd, SimdBase, SimdMask, f32x16, mask32x16};
use glam::DVec3;

use super::apex::Apex;
use super::cone::Cone;
use super::lane_count::LANES;
use super::near_planes::{CELL, NearPlane};
use super::surface::Surface;

/// How far along a ray from its receiver it starts: for planes, and for what faces
/// the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Starts {
    /// At once for planes, but for those that the receiver lies on, and in sides of a
    /// pixel at its depth for what faces the camera.
    Surface(f64),
    /// In scene units.
    Distances([f64; 2]),
}

impl Starts {
    /// In lengths of the rays from a point to others.
    #[inline(always)]
    fn shares(self, frame: &LightFrame, from: DVec3, to: &[[f64; LANES]; 3]) -> [[f64; LANES]; 2] {
        let distances = match self {
            Self::Surface(sides) => [0.0, sides * frame.footprint(from.z)],
            Self::Distances(distances) => distances,
        };
        let mut shares = distances.map(|distance| [distance; LANES]);
        for lane in 0..LANES {
            let away = [0, 1, 2].map(|axis| to[axis][lane] - from[axis]);
            let length = away.map(|along| along * along).iter().sum::<f64>().sqrt();
            shares.iter_mut().for_each(|share| share[lane] /= length);
        }
        shares
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
    /// Lanes that the surface which the receiver lies on keeps from the light.
    pub(crate) behind: u32,
    pub(crate) reach: Reach,
    pub(crate) cone: Cone,
}

/// Where all rays of some count.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reach {
    /// From where on: for planes, and for what faces the camera.
    pub(crate) starts: [f32; 2],
    /// How far: less than 0 if one of them meets nothing at all.
    pub(crate) end: f32,
}

impl Reach {
    /// What both have in common.
    pub(crate) fn and(self, other: Self) -> Self {
        let start = |kind: usize| self.starts[kind].max(other.starts[kind]);
        Self { starts: [start(0), start(1)], end: self.end.min(other.end) }
    }
}

impl Packet {
    /// The rays to up to 16 points of the light.
    #[inline(always)]
    pub(crate) fn new<S: Simd>(
        simd: S,
        frame: &LightFrame,
        apex: &Apex,
        lights: &[DVec3],
        starts: Starts,
        range: [f32; 2],
    ) -> Self {
        // Columns of f64, so that this is computed lane by lane at once.
        let mut world = [[f64::NAN; LANES]; 3];
        for (lane, light) in lights.iter().take(LANES).enumerate() {
            [world[0][lane], world[1][lane], world[2][lane]] = light.to_array();
        }
        let to = frame.camera_points(&world);
        let from = apex.point;
        let (linear, offset) = frame.raster_map();
        let place = linear * (from.truncate() / from.z) + offset;
        let w = from.z.recip();
        let most = f64::from(range[1]).next_up() - w;
        let shares = starts.shares(frame, from, &to);
        let mut slope = [[0.0; LANES]; 2];
        let mut start = [[0.0; LANES]; 2];
        let mut end = [0.0; LANES];
        let mut behind = 0;
        if let Some(normal) = apex.normal {
            let ends = to[0].iter().zip(&to[1]).zip(&to[2]).take(lights.len());
            for (lane, ((&x, &y), &z)) in ends.enumerate() {
                let away = DVec3::new(x, y, z) - from;
                behind |= u32::from(away.dot(normal) < 0.0) << lane;
            }
        }
        for lane in 0..LANES {
            let (x, y, z) = (to[0][lane], to[1][lane], to[2][lane]);
            let away = z - from.z;
            // Pixels per unit of w; finite for points in the camera's plane too.
            let scale = (1.0 - w * z).recip();
            let along_x = linear.x_axis.x * x + linear.y_axis.x * y + (offset.x - place.x) * z;
            let along_y = linear.x_axis.y * x + linear.y_axis.y * y + (offset.y - place.y) * z;
            slope[0][lane] = (along_x * scale) as f32;
            slope[1][lane] = (along_y * scale) as f32;
            // 1/z(t) − 1/z(0) at share t of the way.
            for (start, share) in start.iter_mut().zip(&shares) {
                let share = if share[lane] < 1.0 { share[lane] } else { 1.0 };
                start[lane] = (-share * away * w / (from.z + share * away)) as f32;
            }
            let light = if z > 0.0 { z.recip() - w } else { f64::INFINITY };
            let reach = if light < most { light } else { most };
            // Lights that are no nearer to the camera shade nothing.
            let shades = away < 0.0 && shares[0][lane] < 1.0;
            end[lane] = if shades { reach as f32 } else { -1.0 };
        }
        let Surface { has_side, plane: NearPlane { off, slope: own }, .. } = apex.surface;
        if has_side {
            for lane in 0..lights.len().min(LANES) {
                let along = [slope[0][lane], slope[1][lane]];
                let u = off / (1.0 - (own[0] * along[0] + own[1] * along[1]));
                let near = along.iter().all(|along| (along * u).abs() < CELL);
                behind |= u32::from(u > 0.0 && u < end[lane] && near) << lane;
            }
        }
        let farthest = (f64::from(range[0]) - w) as f32;
        let count = lights.len().min(LANES);
        let packet = Self::finish(simd, (frame.size(), apex, count), slope, start, end, farthest);
        Self { behind, ..packet }
    }

    #[inline(always)]
    fn finish<S: Simd>(
        simd: S,
        (size, apex, count): ([u32; 2], &Apex, usize),
        slope: [[f32; LANES]; 2],
        start: [[f32; LANES]; 2],
        end: [f32; LANES],
        farthest: f32,
    ) -> Self {
        let splat = |value| f32x16::splat(simd, value);
        let load = |column| f32x16::load_array(simd, column);
        let [along_x, along_y] = slope.map(load);
        let last = load(end);
        let first = load(start[0]).min(load(start[1])).max(splat(farthest));
        let most = splat(f32::MAX);
        let finite = along_x.abs().simd_le(most) & along_y.abs().simd_le(most);
        let rays = finite & first.simd_le(last);
        let zero = splat(0.0);
        let mut outside = !rays;
        for (axis, along) in [along_x, along_y].into_iter().enumerate() {
            for u in [first, last] {
                let at = along * u + apex.place[axis];
                outside |= !(at.simd_ge(zero) & at.simd_le(splat(size[axis] as f32)));
            }
        }
        let cone = Cone {
            slopes: [
                [least(along_x, rays), greatest(along_x, rays)],
                [least(along_y, rays), greatest(along_y, rays)],
            ],
            near: least(first, rays),
            far: greatest(last, rays),
            ..Cone::empty(apex.place, apex.w)
        };
        let slope = [along_x, along_y].map(|along| rays.select(along, zero).to_array());
        let end = rays.select(last, splat(-1.0)).to_array();
        let leaving = (outside & rays).to_bitmask() as u32;
        let all = rays.to_bitmask().count_ones() as usize == count;
        let reach = Reach {
            starts: [greatest(load(start[0]), rays), greatest(load(start[1]), rays)],
            end: if all { least(last, rays) } else { -1.0 },
        };
        Self { slope, start, end, leaving, behind: 0, reach, cone }
    }
}

/// The least of the lanes in `some`.
#[inline(always)]
fn least<S: Simd>(column: f32x16<S>, some: mask32x16<S>) -> f32 {
    some.select(column, f32x16::splat(column.simd, f32::INFINITY)).reduce_min()
}

/// The greatest of the lanes in `some`.
#[inline(always)]
fn greatest<S: Simd>(column: f32x16<S>, some: mask32x16<S>) -> f32 {
    some.select(column, f32x16::splat(column.simd, f32::NEG_INFINITY)).reduce_max()
}
