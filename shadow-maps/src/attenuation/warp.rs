//! Places of one view in another (Agrawala et al. 2000, §4, equation 3).

use dsm_core::detail::Result;
use dsm_core::{Error, ShadowCamera};
use dsm_trace::detail::LightFrame;
use glam::{DMat4, DVec2, DVec4};

/// How far a view may stand off the other's plane, of its coordinates, and yet be in it.
const ROUNDING: f64 = 1.0 / (1_u64 << 40) as f64;

/// A map from raster x, y and w = 1/depth of a view to those of another.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "there is one a view")]
pub(super) enum Warp {
    /// Both look the same way from one plane: places move in proportion to w.
    Disparity(DVec2),
    /// Any two, and the inverse: of (x, y, 1, w), up to its scale.
    Projective(DMat4, DMat4),
}

/// The raster of a frame, of points of its camera's space.
fn raster(frame: &LightFrame) -> DMat4 {
    let (linear, offset) = frame.raster_map();
    DMat4::from_cols(
        DVec4::new(linear.x_axis.x, linear.x_axis.y, 0.0, 0.0),
        DVec4::new(linear.y_axis.x, linear.y_axis.y, 0.0, 0.0),
        DVec4::new(-offset.x, -offset.y, -1.0, 0.0),
        DVec4::W,
    )
}

impl Warp {
    /// From the view of a camera to that of another, each with its frame.
    ///
    /// # Errors
    ///
    /// [`Error::Camera`] for matrices that cannot be inverted.
    pub(super) fn new(
        (from, from_frame): (&ShadowCamera, &LightFrame),
        (to, to_frame): (&ShadowCamera, &LightFrame),
    ) -> Result<Self> {
        let [from_world, to_world] =
            [from, to].map(|camera| camera.world_to_camera.unwrap_or_default());
        let turn = to_world * from_world.inverse();
        let same_way = from_frame.basis() == to_frame.basis();
        let (linear, offset) = to_frame.raster_map();
        let off = turn.w_axis.truncate();
        let scale = from_world.w_axis.length() + to_world.w_axis.length();
        if same_way
            && from_frame.raster_map() == (linear, offset)
            && off.z.abs() <= ROUNDING * scale
        {
            return Ok(Self::Disparity(linear * off.truncate()));
        }
        let warp = raster(to_frame) * turn * raster(from_frame).inverse();
        let back = warp.inverse();
        if warp.is_finite() && back.is_finite() {
            return Ok(Self::Projective(warp, back));
        }
        Err(Error::Camera("a view cannot be warped to the light's centre"))
    }

    /// x, y and w in the other view; `None` at its plane or behind it.
    #[inline]
    pub(super) fn there(&self, place: [f64; 3]) -> Option<[f64; 3]> {
        match self {
            Self::Disparity(by) => Some(moved(place, *by)),
            Self::Projective(warp, _) => projected(warp, place),
        }
    }

    /// The inverse of [`Self::there`].
    #[inline]
    pub(super) fn back(&self, place: [f64; 3]) -> Option<[f64; 3]> {
        match self {
            Self::Disparity(by) => Some(moved(place, -*by)),
            Self::Projective(_, back) => projected(back, place),
        }
    }
}

#[inline]
fn moved([x, y, w]: [f64; 3], by: DVec2) -> [f64; 3] {
    [x + by.x * w, y + by.y * w, w]
}

#[inline]
fn projected(warp: &DMat4, [x, y, w]: [f64; 3]) -> Option<[f64; 3]> {
    let place = *warp * DVec4::new(x, y, 1.0, w);
    let DVec4 { x, y, z, w } = place;
    // Depths of both have the sign that they share: w is positive where z is.
    (z > 0.0 && w > 0.0).then(|| [x / z, y / z, w / z])
}

#[cfg(test)]
mod tests {
    use dsm_core::{Projection, View, ViewRaster};
    use glam::DVec3;

    use super::*;

    fn raster(eye: DVec3, target: DVec3) -> ViewRaster {
        let view = View { eye, target, up: DVec3::Y };
        view.raster(Projection::Perspective { fov: 60.0 }, [40, 30]).unwrap()
    }

    /// Both ways, against points of the world.
    fn check(from: &ViewRaster, to: &ViewRaster, is_disparity: bool) {
        let [a, b] = [from, to].map(ViewRaster::shadow_camera);
        let [fa, fb] = [&a, &b].map(|camera| LightFrame::new(camera, [40, 30], 0.0).unwrap());
        let warp = Warp::new((&a, &fa), (&b, &fb)).unwrap();
        assert_eq!(matches!(warp, Warp::Disparity(_)), is_disparity);
        for world in [DVec3::ZERO, DVec3::new(0.5, 0.25, -1.0), DVec3::new(-1.0, 1.0, 1.0)] {
            let [here, there] = [from, to].map(|view| {
                let place = view.project(world).unwrap();
                [place.x, place.y, place.z.recip()]
            });
            for (found, wanted) in [(warp.there(here), there), (warp.back(there), here)] {
                let found = found.unwrap();
                let off = (0..3).map(|axis| (found[axis] - wanted[axis]).abs());
                assert!(off.fold(0.0, f64::max) < 1e-9, "{found:?} {wanted:?}");
            }
        }
    }

    #[test]
    fn places_are_those_of_the_world() {
        let centre = raster(DVec3::new(1.0, 5.0, 2.0), DVec3::ZERO);
        let basis = centre.basis();
        let beside = centre.at_eye(centre.eye() + 0.4 * basis.x_axis - 0.3 * basis.y_axis);
        check(&beside, &centre, true);
        check(&centre, &centre, true);
        check(&centre.moved_back(0.5), &centre, false);
        check(&raster(DVec3::new(0.0, 5.0, 1.0), DVec3::X / 3.0), &centre, false);
    }

    #[test]
    fn what_lies_behind_is_nowhere() {
        let centre = raster(DVec3::Z * 5.0, DVec3::ZERO);
        let behind = centre.moved_back(2.0);
        let [a, b] = [behind, centre].map(|view| view.shadow_camera());
        let [fa, fb] = [&a, &b].map(|camera| LightFrame::new(camera, [40, 30], 0.0).unwrap());
        let warp = Warp::new((&a, &fa), (&b, &fb)).unwrap();
        assert!(warp.there([20.0, 15.0, 1.0 / 2.5]).is_some());
        assert!(warp.there([20.0, 15.0, 1.0 / 1.5]).is_none());
    }
}
