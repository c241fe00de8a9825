//! Cameras and lights of a scene.

use dsm_core::{AreaLight, LightExtent, Projection, View, ViewRaster};

use crate::error::{Error, Place, Result};

/// The camera of a rendered picture.
///
/// ```
/// use dsm_core::View;
/// use dsm_scene::detail::Camera;
/// use glam::DVec3;
///
/// let view = View { eye: DVec3::Z * 5.0, target: DVec3::ZERO, up: DVec3::Y };
/// let camera = Camera { view, fov: 45.0, resolution: [640, 360] };
/// // A quarter of the size, for a preview.
/// let raster = camera.raster([160, 90])?;
/// assert_eq!(raster.resolution(), [160, 90]);
/// # Ok::<(), dsm_scene::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The position and direction of the camera.
    pub view: View,
    /// The full vertical angle of view in degrees, in (0, 180).
    pub fov: f64,
    /// Width and height of the image in pixels, each 1 to 65,536.
    pub resolution: [u32; 2],
}

impl Camera {
    /// The camera's raster at `resolution`.
    ///
    /// # Errors
    ///
    /// [`Error::Malformed`] for a view or an angle that makes no camera, or a
    /// resolution out of range.
    pub fn raster(&self, resolution: [u32; 2]) -> Result<ViewRaster> {
        Ok(self.view.raster_of_height(self.fov, resolution)?)
    }
}

/// A light, and the shadow camera at its centre.
///
/// ```
/// use dsm_core::detail::LightShape;
/// use dsm_core::{LightExtent, Projection, View};
/// use dsm_scene::Light;
/// use glam::DVec3;
///
/// let view = View { eye: DVec3::Y * 5.0, target: DVec3::ZERO, up: DVec3::Z };
/// let projection = Projection::Perspective { fov: 45.0 };
/// let light = Light { view, projection, extent: LightExtent::disk(0.5) };
/// assert_eq!(light.area()?.shape(), LightShape::Disk);
/// assert_eq!(light.raster([512, 512])?.eye(), DVec3::Y * 5.0);
/// let wide = light.with_size([2.0, 2.0])?;
/// assert_eq!(wide.extent, LightExtent::disk(1.0));
/// # Ok::<(), dsm_scene::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// The light's centre, and where the shadow camera looks.
    pub view: View,
    /// Angle or extent of the map's wider side.
    pub projection: Projection,
    /// The light's shape and size, along the right and up axes of the view.
    pub extent: LightExtent,
}

impl Light {
    /// Sets the full width and height, in scene units: of disks and spheres the
    /// diameter. Of size 0 any light is a point, and a point of another size
    /// becomes a rectangle.
    ///
    /// # Errors
    ///
    /// [`Error::Malformed`] for a disk or sphere that is wider than high or
    /// higher than wide; [`Self::area`] refuses other sizes.
    pub fn with_size(self, size: [f64; 2]) -> Result<Self> {
        let Some(extent) = self.extent.with_size(size) else {
            let reason = "a disk or a sphere must be as high as wide";
            return Err(Error::malformed(Place::Named("light size".into()), reason));
        };
        Ok(Self { extent, ..self })
    }

    /// The shadow camera's raster of `resolution` pixels, which are square.
    ///
    /// # Errors
    ///
    /// [`Error::Core`] for a view, an angle or an extent that makes no
    /// camera, or a resolution out of range.
    pub fn raster(&self, resolution: [u32; 2]) -> Result<ViewRaster> {
        Ok(self.view.raster(self.projection, resolution)?)
    }

    /// The light's area in the world.
    ///
    /// # Errors
    ///
    /// [`Error::Malformed`] for a view that makes no camera, or a size that is
    /// negative or not finite.
    pub fn area(&self) -> Result<AreaLight> {
        let basis = self.view.basis()?;
        if !self.extent.size().iter().all(|size| (0.0..=1e18).contains(size)) {
            let reason = "a light's size must lie between 0 and 1e18";
            return Err(Error::malformed(Place::Named("light".into()), reason));
        }
        Ok(self.extent.placed(self.view.eye, [basis.x_axis, basis.y_axis]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec2, DVec3};

    fn light(projection: Projection, up: DVec3) -> Light {
        let view = View { eye: DVec3::new(1.0, 5.0, 2.0), target: DVec3::new(0.5, 1.0, 0.0), up };
        Light { view, projection, extent: LightExtent::rectangle([2.0, 1.0]) }
    }

    #[test]
    fn rays_go_where_the_matrices_project() {
        for projection in
            [Projection::Perspective { fov: 40.0 }, Projection::Orthographic { extent: 4.0 }]
        {
            for resolution in [[64, 64], [64, 16], [16, 64]] {
                let raster = light(projection, DVec3::Y).raster(resolution).unwrap();
                let camera = raster.shadow_camera();
                for (x, y, depth) in [(0.5, 0.5, 3.0), (13.25, 9.0, 1.0), (16.0, 16.0, 20.0)] {
                    let ray = raster.ray(x, y, 0.0);
                    let projected = camera.project(ray.at(depth)).unwrap().unwrap();
                    let size = DVec2::from(resolution.map(f64::from));
                    let back = projected.truncate() * size;
                    assert!((back - DVec2::new(x, y)).length() < 1e-4, "{back} {x} {y}");
                    assert!((projected.z - depth).abs() < 1e-5);
                    let factor = camera.distance_per_depth(x / size.x, y / size.y).unwrap();
                    assert!((factor - ray.direction().length()).abs() < 1e-5);
                }
            }
        }
    }

    #[test]
    fn the_wider_side_has_the_angle() {
        let projection = Projection::Perspective { fov: 60.0 };
        let tall = light(projection, DVec3::Y).raster([10, 40]).unwrap();
        let top = tall.ray(5.0, 0.0, 0.0).direction().normalize();
        let bottom = tall.ray(5.0, 40.0, 0.0).direction().normalize();
        assert!((top.angle_between(bottom).to_degrees() - 60.0).abs() < 1e-9);
        let camera =
            Camera { view: light(projection, DVec3::Y).view, fov: 60.0, resolution: [40, 10] };
        let wide = camera.raster([40, 10]).unwrap();
        let top = wide.ray(20.0, 0.0, 0.0).direction().normalize();
        let bottom = wide.ray(20.0, 10.0, 0.0).direction().normalize();
        assert!((top.angle_between(bottom).to_degrees() - 60.0).abs() < 1e-9);
    }

    #[test]
    fn an_up_along_the_view_gives_way_to_an_axis() {
        let view = View { eye: DVec3::Y * 5.0, target: DVec3::ZERO, up: DVec3::Y };
        for up in [DVec3::Y, DVec3::NEG_Y, DVec3::ZERO, DVec3::new(1e-9, 1.0, 0.0)] {
            let basis = View { up, ..view }.basis().unwrap();
            assert!((basis.determinant() - 1.0).abs() < 1e-12, "{basis}");
            assert_eq!(basis.z_axis, DVec3::Y);
            assert_eq!(basis.y_axis, DVec3::X, "x is the first of the least aligned");
        }
    }

    #[test]
    fn lights_take_another_size() {
        let plain = light(Projection::Perspective { fov: 40.0 }, DVec3::Y);
        let extent = |extent, size| Light { extent, ..plain }.with_size(size).map(|l| l.extent);
        let disk = LightExtent::disk(3.0);
        assert_eq!(extent(disk, [1.0; 2]).unwrap(), LightExtent::disk(0.5));
        assert_eq!(extent(disk, [0.0; 2]).unwrap(), LightExtent::POINT);
        assert!(extent(disk, [1.0, 2.0]).is_err());
        let size = [1.0, 2.0];
        assert_eq!(extent(LightExtent::POINT, size).unwrap(), LightExtent::rectangle(size));
        assert!(plain.with_size([1.0, f64::NAN]).unwrap().area().is_err());
    }

    #[test]
    fn odd_views_are_refused() {
        let plain = light(Projection::Perspective { fov: 40.0 }, DVec3::Y);
        let same = View { target: plain.view.eye, ..plain.view };
        assert!(Light { view: same, ..plain }.raster([8, 8]).is_err());
        let nowhere = View { eye: DVec3::NAN, ..plain.view };
        assert!(Light { view: nowhere, ..plain }.area().is_err());
        for fov in [0.0, 180.0, -1.0, f64::NAN] {
            let projection = Projection::Perspective { fov };
            assert!(Light { projection, ..plain }.raster([8, 8]).is_err());
        }
        for extent in [0.0, -1.0, f64::INFINITY] {
            let projection = Projection::Orthographic { extent };
            assert!(Light { projection, ..plain }.raster([8, 8]).is_err());
        }
        assert!(plain.raster([0, 8]).is_err());
        let extent = LightExtent::disk(-1.0);
        assert!(Light { extent, ..plain }.area().is_err());
    }
}
