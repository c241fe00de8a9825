//! The rays of a shadow camera over a map.

use dsm_core::detail::Result;
use dsm_core::{Error, ShadowCamera, ViewRaster};
use glam::{DMat2, DVec2, DVec3};

/// The share below which a change of w over the width of a map changes no `f32`: w
/// counts as constant.
const SLIGHT: f64 = 1.0 / (1 << 24) as f64;

/// The rays of a camera in *ray space*: camera space with depths instead of z,
/// sheared and shifted so that rays are simple. Those of a perspective camera
/// start at the origin and gain `ray` sideways per unit of depth. Those of an
/// orthographic one are parallel to the depth axis, at `ray`. Either way `ray`
/// is linear in the raster position.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rays {
    /// The map from raster positions.
    inverse: DMat2,
    /// The map to raster positions: `linear · ray + offset`.
    linear: DMat2,
    offset: DVec2,
    /// The origin of ray space, in camera space with depths.
    origin: DVec3,
    /// The sideways gain of parallel rays per unit of depth; 0 in perspective.
    slope: DVec2,
    perspective: bool,
}

impl Rays {
    /// The rays through a map of `size` pixels.
    pub(super) fn new(camera: &ShadowCamera, size: [u32; 2]) -> Result<Self> {
        let (projection, rounding) = camera.projection()?;
        let [x, y, w] = [0, 1, 3].map(|row| projection.row(row));
        let off = rounding.row(3);
        // With depth = −z, homogeneous raster positions are
        // linear · (X, Y) + along · depth + constant over w.
        let size = DVec2::from(size.map(f64::from));
        let linear = DMat2::from_cols(DVec2::new(x.x, y.x) * size, DVec2::new(x.y, y.y) * size);
        let along = -DVec2::new(x.z, y.z) * size;
        let constant = DVec2::new(x.w, y.w) * size;
        let refused = Error::Camera("the matrices do not make a projection");
        // w per length, where it changes by all of itself over the map's width.
        let steep = x.truncate().truncate().length().max(y.truncate().truncate().length());
        let slight = |axis: usize| w[axis].abs() <= off[axis].max(SLIGHT * steep);
        // Parallel rays meet nowhere; others may meet where the camera stands.
        let perspective = w.w.abs() <= off.w || !slight(2);
        let scale = if perspective { -w.z } else { w.w };
        if !(slight(0) && slight(1)) {
            return Err(Error::Camera("depths must be measured along the view axis"));
        }
        if scale <= 0.0 || scale.is_nan() {
            return Err(refused);
        }
        let (linear, along, constant) = (linear * scale.recip(), along / scale, constant / scale);
        let back = linear.inverse();
        let rays = if perspective {
            // The pinhole, where w and both numerators vanish.
            let depth = -w.w / scale;
            let sideways = back * -(constant + along * depth);
            Self {
                inverse: back,
                linear,
                offset: along,
                origin: sideways.extend(depth),
                slope: DVec2::ZERO,
                perspective,
            }
        } else {
            let slope = back * -along;
            Self {
                inverse: back,
                linear,
                offset: constant,
                origin: DVec3::ZERO,
                slope,
                perspective,
            }
        };
        let numbers = [rays.offset, rays.slope, rays.origin.truncate(), back.x_axis, back.y_axis];
        if numbers.iter().all(|pair| pair.is_finite()) && linear.determinant() != 0.0 {
            Ok(rays)
        } else {
            Err(refused)
        }
    }

    /// The rays of a view, whose numbers are exact.
    pub(super) fn of_view(view: &ViewRaster) -> Self {
        let size = DVec2::from(view.resolution().map(f64::from));
        let per_half = DVec2::new(0.5, -0.5) / view.half_size() * size;
        Self {
            inverse: DMat2::from_diagonal(per_half.recip()),
            linear: DMat2::from_diagonal(per_half),
            offset: size * 0.5,
            origin: DVec3::ZERO,
            slope: DVec2::ZERO,
            perspective: view.is_perspective(),
        }
    }

    /// A point of camera space (which looks down −z) in ray space.
    pub(super) fn point(&self, point: DVec3) -> DVec3 {
        let point = DVec3::new(point.x, point.y, -point.z) - self.origin;
        (point.truncate() - self.slope * point.z).extend(point.z)
    }

    /// The offset from a depth in ray space to that in camera space.
    pub(super) const fn depth_offset(&self) -> f64 {
        self.origin.z
    }

    /// The sideways shift of points of camera space per unit of depth.
    pub(super) const fn shear(&self) -> DVec2 {
        self.slope
    }

    /// True if all rays start in one point.
    pub(super) const fn is_perspective(&self) -> bool {
        self.perspective
    }

    /// The ray through a raster position.
    pub(super) fn through(&self, raster: DVec2) -> DVec2 {
        self.inverse * (raster - self.offset)
    }

    /// The raster position of a ray.
    pub(super) fn raster(&self, ray: DVec2) -> DVec2 {
        self.linear * ray + self.offset
    }

    /// The sideways movement of a ray in camera space per unit of depth.
    pub(super) fn slope(&self, ray: DVec2) -> DVec2 {
        if self.perspective { ray } else { self.slope }
    }

    /// Half axes of an ellipse in the raster around all rays that differ from
    /// one by at most 1.
    pub(super) fn stretch(&self) -> [f64; 2] {
        let rows = [self.linear.row(0), self.linear.row(1)];
        let upright = |[a, b]: [f64; 2]| a == 0.0 || b == 0.0;
        let upright = rows.iter().all(|row| upright(row.to_array()));
        // Around the box of a slanted one.
        rows.map(|row| row.length() * if upright { 1.0 } else { std::f64::consts::SQRT_2 })
    }

    /// A function of ray space, linear in the point, whose sign tells on which
    /// side of raster coordinate `axis` = `at` a point in front of the camera
    /// projects, and how fast it changes per unit of space at most.
    pub(super) fn side(&self, axis: usize, at: f64) -> (impl Fn(DVec3) -> f64, f64) {
        let across = self.linear.row(axis);
        let constant = self.offset[axis] - at;
        let perspective = self.perspective;
        let side = move |point: DVec3| {
            across.dot(point.truncate()) + constant * if perspective { point.z } else { 1.0 }
        };
        let slope = if perspective { constant } else { across.dot(self.slope) };
        (side, across.extend(slope).length())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::oracle::{orthographic, perspective, placed};
    use glam::{DMat4, DQuat};

    /// Every point lies on the ray through its projection.
    fn check(camera: &ShadowCamera) {
        let rays = Rays::new(camera, [40, 30]).unwrap();
        let to_camera = camera.world_to_camera.unwrap();
        for world in [DVec3::new(0.3, -0.2, 0.1), DVec3::new(-1.0, 0.5, 2.0), DVec3::ZERO] {
            let projected = camera.project(world).unwrap().unwrap();
            let raster = projected.truncate() * DVec2::new(40.0, 30.0);
            let point = rays.point(to_camera.transform_point3(world));
            let depth = point.z + rays.depth_offset();
            assert!((depth / projected.z - 1.0).abs() < 1e-6);
            let ray = rays.through(raster);
            let at = if rays.is_perspective() { ray * point.z } else { ray };
            assert!((at - point.truncate()).length() < 1e-5, "{at} {point}");
            assert!((rays.raster(ray) - raster).length() < 1e-9);
            for axis in 0..2 {
                let (side, _) = rays.side(axis, 7.25);
                assert_eq!(side(point) > 0.0, raster[axis] > 7.25);
            }
        }
    }

    #[test]
    fn points_lie_on_the_rays_they_project_to() {
        let apart = DMat4::from_translation(-DVec3::new(1.0, 2.0, 5.0));
        let turn = DQuat::from_rotation_y(0.4) * DQuat::from_rotation_x(-0.3);
        let turn = DMat4::from_quat(turn);
        // An off-axis window, as of a portal in a wall.
        let mut shear = DMat4::IDENTITY;
        (shear.z_axis.x, shear.z_axis.y) = (0.2, -0.1);
        for camera in [perspective(50.0, 1.5), orthographic(6.0, 1.5)] {
            check(&placed(camera, apart));
            check(&placed(camera, apart * turn));
            let window = camera.world_to_ndc.map(|matrix| matrix * shear);
            check(&placed(ShadowCamera { world_to_ndc: window, ..camera }, apart));
        }
    }

    #[test]
    fn places_and_sizes_of_the_world_do_not_matter() {
        for camera in [perspective(50.0, 1.5), perspective(1e-4, 1.0), orthographic(6.0, 1.5)] {
            let here = Rays::new(&camera, [40, 30]).unwrap();
            for (scale, radii) in [1e-6, 1e-3, 1.0, 1e3, 1e6]
                .into_iter()
                .flat_map(|scale| [0.0, 150.0, 1e4].map(|radii| (scale, radii)))
            {
                let shift = DVec3::new(0.6, -0.5, 0.62) * (radii * scale);
                let back = DMat4::from_translation(-shift);
                let small = DMat4::from_scale(DVec3::splat(scale.recip()));
                let large = DMat4::from_scale(DVec3::splat(scale));
                let placed = ShadowCamera {
                    world_to_camera: Some(large * small * back),
                    world_to_ndc: camera.world_to_ndc.map(|matrix| matrix * small * back),
                };
                let there = Rays::new(&placed, [40, 30]).unwrap();
                assert_eq!(there.is_perspective(), here.is_perspective(), "{scale} {radii}");
                let unit = if here.is_perspective() { 1.0 } else { scale };
                let raster = DVec2::new(11.5, 3.25);
                let [want, have] = [here.through(raster) * unit, there.through(raster)];
                let reach = if here.is_perspective() { 1.0 } else { radii.max(1.0) };
                assert!((have - want).length() <= 1e-12 * unit * reach, "{scale} {radii}");
            }
        }
    }

    #[test]
    fn what_is_no_projection_is_refused() {
        let camera = perspective(50.0, 1.0);
        for world_to_ndc in [None, Some(DMat4::ZERO), Some(DMat4::NAN), Some(-DMat4::IDENTITY)] {
            assert!(Rays::new(&ShadowCamera { world_to_ndc, ..camera }, [4, 4]).is_err());
        }
        let tilted = DMat4::from_rotation_y(0.1);
        let world_to_camera = camera.world_to_camera.map(|matrix| tilted * matrix);
        assert!(Rays::new(&ShadowCamera { world_to_camera, ..camera }, [4, 4]).is_err());
    }
}
