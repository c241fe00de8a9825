//! The receiver of a group of rays, in the frame of a light.

use dsm_core::Facing;
use dsm_trace::detail::LightFrame;
use fearless_simd::{Select, Simd, SimdBase, SimdMask, f32x16};
use glam::DVec3;

use super::groups::SAME_PLANE;
use super::near_planes::NearPlane;
use super::packed::Planes;
use super::range_tree::Block;
use super::surface::Surface;

/// What places and planes are rounded by, as a share: a few times the rounding of
/// `f32`, as they are differences of rounded numbers.
const ROUNDING: f64 = 4.0 * f32::EPSILON as f64;

/// The point that rays start at, and the surface that it lies on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Apex {
    pub(crate) place: [f32; 2],
    /// The corner of its pixel, and where it is in it: more exact than their sum.
    pub(crate) corner: [f32; 2],
    pub(crate) within: [f32; 2],
    pub(crate) w: f32,
    /// In camera space, with the depth for z.
    pub(crate) point: DVec3,
    /// The normal of the surface that it lies on, on the side that is shaded, in that
    /// space.
    pub(crate) normal: Option<DVec3>,
    /// The slope of that surface, if it is known from the normal.
    pub(crate) slope: Option<[f32; 2]>,
    /// The side of a pixel at depth 1.
    pub(crate) footprint: f32,
    pub(crate) surface: Surface,
}

/// The fragments of a block as they lie to an apex.
pub(crate) struct Distances<S: Simd> {
    /// How far their pixels lie before its own: whole numbers.
    pub(crate) step: [f32x16<S>; 2],
    /// How far they lie before it.
    pub(crate) beyond: [f32x16<S>; 2],
    /// By how much more w their planes have there: NaN where that is its own surface.
    pub(crate) distance: f32x16<S>,
    /// Bits of those that may be settled by its surface.
    pub(crate) doubtful: u32,
}

/// By how much a receiver may be off: coordinates that all are numbers of 32 bits may have
/// been rounded to them, and others to 64.
fn coordinate_error(receiver: DVec3) -> f64 {
    let is_single = receiver.as_vec3().as_dvec3() == receiver;
    let share = if is_single { ROUNDING } else { 4.0 * f64::EPSILON };
    share * receiver.abs().max_element()
}

impl Apex {
    /// `None` where nothing can shade a receiver: no deeper than the light's
    /// centre, or not finite.
    pub(crate) fn new(frame: &LightFrame, receiver: DVec3, facing: Facing) -> Option<Self> {
        let place = frame.project(receiver)?;
        let point = frame.camera_point(receiver);
        let at = [place.x, place.y];
        let corner = at.map(|at| at.floor() as f32);
        let within = [0, 1].map(|axis| (at[axis] - f64::from(corner[axis])) as f32);
        let w = place.z as f32;
        let finite = at.iter().all(|at| (*at as f32).is_finite()) && w.is_finite();
        if !(finite && point.z > frame.light_depth()) {
            return None;
        }
        // A fragment's plane is that of some of its hits; where the receiver is, its
        // coordinates say as well as their bits do.
        let error = coordinate_error(receiver);
        let footprint = frame.footprint(1.0);
        let room = place.z * (ROUNDING + error * place.z + SAME_PLANE * footprint);
        let per_slope = error / frame.footprint(point.z) + 8.0 * ROUNDING;
        let (mut normal, mut slope) = (None, None);
        if let Facing::Surface(world) = facing {
            let camera = frame.basis().transpose() * world;
            normal = Some(DVec3::new(camera.x, camera.y, -camera.z));
            let along = frame.plane(at[0], at[1], point.z, camera);
            slope = along.map(|slope| slope.map(|along| along as f32));
            slope = slope.filter(|slope| slope.iter().all(|along| along.is_finite()));
        }
        Some(Self {
            place: at.map(|at| at as f32),
            corner,
            within,
            w,
            point,
            normal,
            slope,
            footprint: footprint as f32,
            surface: Surface::passing(room as f32, per_slope as f32),
        })
    }

    /// The same on nothing: all planes count.
    pub(crate) fn without_surface(self) -> Self {
        Self { normal: None, slope: None, surface: Surface::passing(-1.0, 0.0), ..self }
    }

    /// The fragments of `block` as they lie to it.
    #[inline(always)]
    pub(crate) fn distances<S: Simd>(
        &self,
        simd: S,
        block: Block,
        some: &Planes<S>,
    ) -> Distances<S> {
        let splat = |value| f32x16::splat(simd, value);
        let step = [0, 1].map(|axis| {
            let from = self.corner[axis] - 4.0 * block.at[axis] as f32;
            splat(from) - some.at[axis]
        });
        let beyond = [0, 1].map(|axis| step[axis] + splat(self.within[axis]));
        let [along_x, along_y] = some.gradient;
        let distance =
            (some.w - self.w) + (along_x * (beyond[0] - 0.5) + along_y * (beyond[1] - 0.5));
        let Surface { room, per_slope, per_turn, plane: NearPlane { off, slope }, .. } =
            self.surface;
        let room = (along_x.abs() + along_y.abs()) * per_slope + room;
        let turned = (along_x - slope[0]).abs() + (along_y - slope[1]).abs();
        let own = distance.abs().simd_le(room);
        let from_own = (distance - off).abs();
        let doubtful = from_own.simd_le(room + turned * per_turn).to_bitmask() as u32;
        Distances { step, beyond, distance: own.select(splat(f32::NAN), distance), doubtful }
    }
}
