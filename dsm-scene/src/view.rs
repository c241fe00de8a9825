//! Cameras: the one that renders and the one that sits at the light.

use dsm_core::{AreaLight, ShadowCamera};
use glam::{DMat3, DMat4, DVec2, DVec3, DVec4};

use crate::error::{Error, Place, Result};
use crate::trace::Ray;

/// How a view maps directions to pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Through one point; `fov` is the full angle in degrees, in (0, 180).
    Perspective {
        /// The angle of view.
        fov: f64,
    },
    /// Along one direction; `extent` is the full width in scene units, > 0.
    Orthographic {
        /// The width of view.
        extent: f64,
    },
}

/// From where something is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The position.
    pub eye: DVec3,
    /// What lies in the middle.
    pub target: DVec3,
    /// What points upwards; where it is parallel to the view, the axis serves
    /// that is least aligned with it.
    pub up: DVec3,
}

impl View {
    /// The right, the up and the backward axis of the view: an orthonormal,
    /// right-handed basis.
    ///
    /// # Errors
    ///
    /// [`Error::Malformed`] if `eye` and `target` are one point, or a number
    /// is not finite or beyond 1e18.
    pub fn basis(&self) -> Result<DMat3> {
        let refuse = |what: &str, reason| Err(Error::malformed(Place::Named(what.into()), reason));
        let sound = |point: DVec3| point.abs().cmple(DVec3::splat(1e18)).all();
        for (name, point) in [("eye", self.eye), ("target", self.target), ("up", self.up)] {
            if !sound(point) {
                return refuse(name, "coordinates must be finite and at most 1e18");
            }
        }
        let Some(back) = (self.eye - self.target).try_normalize() else {
            return refuse("target", "must be another point than eye");
        };
        let across = |up: DVec3| {
            let right = up.try_normalize()?.cross(back);
            (right.length() > 1e-6).then(|| right.normalize())
        };
        let axes = back.abs().to_array();
        let least = (0..3).min_by(|&a, &b| axes[a].total_cmp(&axes[b])).unwrap_or(0);
        let Some(right) = across(self.up).or_else(|| across(DVec3::AXES[least])) else {
            return refuse("up", "no axis is across the view");
        };
        Ok(DMat3::from_cols(right, back.cross(right), back))
    }
}

/// The camera that renders.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// From where.
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
        let half_height = half_tangent(self.fov)?;
        let [width, height] = check_resolution(resolution)?;
        let half = DVec2::new(half_height * width / height, half_height);
        ViewRaster::new(self.view, half, true, resolution)
    }
}

/// The outline of a light in a scene: its axes are those of its view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightOutline {
    /// A point.
    Point,
    /// A rectangle, by its full width and height in scene units.
    Rectangle {
        /// Along the view's right and up axes.
        size: [f64; 2],
    },
    /// A disk that faces the target.
    Disk {
        /// Its radius in scene units.
        radius: f64,
    },
    /// A sphere.
    Sphere {
        /// Its radius in scene units.
        radius: f64,
    },
}

/// A light, and the shadow camera at its centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// The light's centre, and where the shadow camera looks.
    pub view: View,
    /// Angle or extent of the map's wider side.
    pub projection: Projection,
    /// The light's outline.
    pub outline: LightOutline,
}

impl Light {
    /// The same light of another full width and height, in scene units: of
    /// disks and spheres the diameter. Nothing of any size is a point, and a
    /// point of some size a rectangle.
    ///
    /// # Errors
    ///
    /// [`Error::Malformed`] for a disk or sphere that is wider than high or
    /// higher than wide; [`Self::area`] refuses other sizes.
    pub fn with_size(self, size: [f64; 2]) -> Result<Self> {
        let [width, height] = size;
        let outline = match self.outline {
            _ if size == [0.0; 2] => LightOutline::Point,
            LightOutline::Point | LightOutline::Rectangle { .. } => {
                LightOutline::Rectangle { size }
            }
            _ if width != height => {
                let reason = "a disk or a sphere is as high as wide";
                return Err(Error::malformed(Place::Named("light size".into()), reason));
            }
            LightOutline::Disk { .. } => LightOutline::Disk { radius: width / 2.0 },
            LightOutline::Sphere { .. } => LightOutline::Sphere { radius: width / 2.0 },
        };
        Ok(Self { outline, ..self })
    }

    /// The shadow camera's raster of `resolution` pixels, which are square.
    ///
    /// # Errors
    ///
    /// [`Error::Malformed`] for a view, an angle or an extent that makes no
    /// camera, or a resolution out of range.
    pub fn raster(&self, resolution: [u32; 2]) -> Result<ViewRaster> {
        let (half, perspective) = match self.projection {
            Projection::Perspective { fov } => (half_tangent(fov)?, true),
            Projection::Orthographic { extent } if (1e-18..=1e18).contains(&extent) => {
                (extent / 2.0, false)
            }
            Projection::Orthographic { .. } => {
                let reason = "must lie between 1e-18 and 1e18";
                return Err(Error::malformed(Place::Named("extent".into()), reason));
            }
        };
        let size = DVec2::from(check_resolution(resolution)?);
        ViewRaster::new(self.view, size * (half / size.max_element()), perspective, resolution)
    }

    /// The light's area in the world.
    ///
    /// # Errors
    ///
    /// [`Error::Malformed`] for a view that makes no camera, or a size that is
    /// negative or not finite.
    pub fn area(&self) -> Result<AreaLight> {
        let basis = self.view.basis()?;
        let centre = self.view.eye;
        let sound = |size: f64| {
            if (0.0..=1e18).contains(&size) {
                Ok(size)
            } else {
                let reason = "a light's size must lie between 0 and 1e18";
                Err(Error::malformed(Place::Named("light".into()), reason))
            }
        };
        Ok(match self.outline {
            LightOutline::Point => AreaLight::point(centre),
            LightOutline::Rectangle { size: [width, height] } => {
                let (right, up) = (sound(width)? / 2.0, sound(height)? / 2.0);
                AreaLight::rectangle(centre, basis.x_axis * right, basis.y_axis * up)
            }
            LightOutline::Disk { radius } => {
                let radius = sound(radius)?;
                AreaLight::disk(centre, basis.x_axis * radius, basis.y_axis * radius)
            }
            LightOutline::Sphere { radius } => AreaLight::sphere(centre, sound(radius)?),
        })
    }
}

/// A view over pixels: x right, y down, pixel (i, j) covers [i, i + 1) ×
/// [j, j + 1).
///
/// ```
/// use dsm_scene::{Light, LightOutline, Projection, View};
/// use glam::DVec3;
///
/// let view = View { eye: DVec3::Z * 5.0, target: DVec3::ZERO, up: DVec3::Y };
/// let projection = Projection::Perspective { fov: 90.0 };
/// let light = Light { view, projection, outline: LightOutline::Point };
/// let raster = light.raster([64, 32])?;
/// // The upper left corner of the wide map; the wider side has the angle.
/// let ray = raster.ray(0.0, 0.0, 0.0);
/// assert!((ray.at(5.0) - DVec3::new(-5.0, 2.5, 0.0)).length() < 1e-12);
/// // Its parameter is the depth, not the distance.
/// let projected = raster.shadow_camera().project(ray.at(5.0))?.unwrap();
/// assert!((projected - DVec3::new(0.0, 0.0, 5.0)).length() < 1e-6);
/// # Ok::<(), dsm_scene::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewRaster {
    eye: DVec3,
    basis: DMat3,
    /// Half the width and height: at depth 1, or at any if orthographic.
    half: DVec2,
    perspective: bool,
    resolution: [u32; 2],
}

impl ViewRaster {
    fn new(view: View, half: DVec2, perspective: bool, resolution: [u32; 2]) -> Result<Self> {
        Ok(Self { eye: view.eye, basis: view.basis()?, half, perspective, resolution })
    }

    /// Width and height in pixels.
    #[must_use]
    pub fn resolution(&self) -> [u32; 2] {
        self.resolution
    }

    /// The camera's position.
    #[must_use]
    pub fn eye(&self) -> DVec3 {
        self.eye
    }

    /// The camera's right, up and backward axes in the world.
    #[must_use]
    pub fn basis(&self) -> DMat3 {
        self.basis
    }

    /// Whether rays go through one point.
    #[must_use]
    pub fn is_perspective(&self) -> bool {
        self.perspective
    }

    /// Half the width and height of the view: at depth 1 in perspective, in
    /// scene units otherwise.
    #[must_use]
    pub fn half_size(&self) -> DVec2 {
        self.half
    }

    /// The same view from `distance` further back, its angle unchanged.
    #[must_use]
    pub fn moved_back(&self, distance: f64) -> Self {
        Self { eye: self.eye + self.basis.z_axis * distance, ..*self }
    }

    /// The ray through raster point (`x`, `y`) at `time` of the shutter. Its
    /// parameter is the depth along the view axis.
    #[must_use]
    pub fn ray(&self, x: f64, y: f64, time: f64) -> Ray {
        let [width, height] = self.resolution.map(f64::from);
        let across = DVec2::new(2.0 * x / width - 1.0, 1.0 - 2.0 * y / height) * self.half;
        let across = self.basis.x_axis * across.x + self.basis.y_axis * across.y;
        if self.perspective {
            Ray::new(self.eye, across - self.basis.z_axis).at_time(time)
        } else {
            Ray::new(self.eye + across, -self.basis.z_axis).at_time(time)
        }
    }

    /// The matrices of a map from here.
    #[must_use]
    pub fn shadow_camera(&self) -> ShadowCamera {
        let rotation = self.basis.transpose();
        let view = DMat4::from_mat3(rotation) * DMat4::from_translation(-self.eye);
        let (x, y) = (0.5 / self.half.x, -0.5 / self.half.y);
        let projection = if self.perspective {
            DMat4::from_cols(
                DVec4::new(x, 0.0, 0.0, 0.0),
                DVec4::new(0.0, y, 0.0, 0.0),
                DVec4::new(-0.5, -0.5, -1.0, -1.0),
                DVec4::ZERO,
            )
        } else {
            DMat4::from_cols(
                DVec4::new(x, 0.0, 0.0, 0.0),
                DVec4::new(0.0, y, 0.0, 0.0),
                DVec4::new(0.0, 0.0, -1.0, 0.0),
                DVec4::new(0.5, 0.5, 0.0, 1.0),
            )
        };
        ShadowCamera { world_to_camera: Some(view), world_to_ndc: Some(projection * view) }
    }
}

fn half_tangent(fov: f64) -> Result<f64> {
    if (1e-6..=179.999).contains(&fov) {
        let (sin, cos) = libm::sincos((fov / 2.0).to_radians());
        Ok(sin / cos)
    } else {
        Err(Error::malformed(Place::Named("fov".into()), "must lie between 0 and 180 degrees"))
    }
}

fn check_resolution(resolution: [u32; 2]) -> Result<[f64; 2]> {
    if resolution.iter().all(|side| (1..=65_536).contains(side)) {
        Ok(resolution.map(f64::from))
    } else {
        let reason = "must lie between 1 and 65,536 pixels";
        Err(Error::malformed(Place::Named("resolution".into()), reason))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn light(projection: Projection, up: DVec3) -> Light {
        let view = View { eye: DVec3::new(1.0, 5.0, 2.0), target: DVec3::new(0.5, 1.0, 0.0), up };
        Light { view, projection, outline: LightOutline::Rectangle { size: [2.0, 1.0] } }
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
        let outline = |outline, size| Light { outline, ..plain }.with_size(size).map(|l| l.outline);
        let disk = LightOutline::Disk { radius: 3.0 };
        assert_eq!(outline(disk, [1.0; 2]).unwrap(), LightOutline::Disk { radius: 0.5 });
        assert_eq!(outline(disk, [0.0; 2]).unwrap(), LightOutline::Point);
        assert!(outline(disk, [1.0, 2.0]).is_err());
        let size = [1.0, 2.0];
        assert_eq!(outline(LightOutline::Point, size).unwrap(), LightOutline::Rectangle { size });
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
        let outline = LightOutline::Disk { radius: -1.0 };
        assert!(Light { outline, ..plain }.area().is_err());
    }
}
