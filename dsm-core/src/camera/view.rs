//! Positions and directions of cameras.

use glam::{DMat3, DVec2, DVec3};

use super::view_raster::ViewRaster;
use crate::error::{Error, Result};

/// The projection of a camera.
///
/// ```
/// use dsm_core::{Projection, View};
/// use glam::DVec3;
///
/// let view = View { eye: DVec3::Z * 5.0, target: DVec3::ZERO, up: DVec3::Y };
/// let raster = view.raster(Projection::Orthographic { extent: 4.0 }, [64, 32])?;
/// assert!(!raster.is_perspective());
/// assert_eq!(raster.half_size(), glam::DVec2::new(2.0, 1.0));
/// # Ok::<(), dsm_core::Error>(())
/// ```
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

/// A view: a position, a target and an up vector.
///
/// ```
/// use dsm_core::{Projection, View};
/// use glam::DVec3;
///
/// let view = View { eye: DVec3::Z * 5.0, target: DVec3::ZERO, up: DVec3::Y };
/// let raster = view.raster(Projection::Perspective { fov: 90.0 }, [64, 32])?;
/// // Sample to ray: its parameter is the depth.
/// let point = raster.ray(48.0, 16.0, 0.0).at(5.0);
/// // World to sample.
/// let sample = raster.project(point).unwrap();
/// assert!((sample - DVec3::new(48.0, 16.0, 5.0)).length() < 1e-12);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The position.
    pub eye: DVec3,
    /// The point in the middle of the view.
    pub target: DVec3,
    /// The up vector; where it is parallel to the view, the axis serves that is
    /// least aligned with it.
    pub up: DVec3,
}

impl View {
    /// The right, the up and the backward axis of the view: an orthonormal,
    /// right-handed basis.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] if `eye` and `target` are one point, or a number
    /// is not finite or beyond 1e18.
    pub fn basis(&self) -> Result<DMat3> {
        let refuse = |setting, reason| Err(Error::Setting { setting, reason });
        let sound = |point: DVec3| point.abs().cmple(DVec3::splat(1e18)).all();
        for (name, point) in [("eye", self.eye), ("target", self.target), ("up", self.up)] {
            if !sound(point) {
                return refuse(name, "coordinates must be finite and at most 1e18");
            }
        }
        let Some(back) = (self.eye - self.target).try_normalize() else {
            return refuse("target", "must differ from eye");
        };
        let across = |up: DVec3| {
            let right = up.try_normalize()?.cross(back);
            (right.length() > 1e-6).then(|| right.normalize())
        };
        let axes = back.abs().to_array();
        let least = (0..3).min_by(|&a, &b| axes[a].total_cmp(&axes[b])).unwrap_or(0);
        let Some(right) = across(self.up).or_else(|| across(DVec3::AXES[least])) else {
            return refuse("up", "no axis is perpendicular to the view");
        };
        Ok(DMat3::from_cols(right, back.cross(right), back))
    }

    /// The raster of `resolution` square pixels, 1 to 65,536 a side, whose wider
    /// side has the projection's angle or extent.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] for a view, an angle or an extent that makes no camera,
    /// or a resolution out of range.
    pub fn raster(self, projection: Projection, resolution: [u32; 2]) -> Result<ViewRaster> {
        let (half, perspective) = match projection {
            Projection::Perspective { fov } => (half_tangent(fov)?, true),
            Projection::Orthographic { extent } if (1e-18..=1e18).contains(&extent) => {
                (extent / 2.0, false)
            }
            Projection::Orthographic { .. } => {
                let reason = "must lie between 1e-18 and 1e18";
                return Err(Error::Setting { setting: "extent", reason });
            }
        };
        let size = DVec2::from(check_resolution(resolution)?);
        ViewRaster::new(self, size * (half / size.max_element()), perspective, resolution)
    }

    /// The raster in perspective whose height has the full angle `fov`, in degrees,
    /// in (0, 180).
    ///
    /// # Errors
    ///
    /// As [`Self::raster`].
    pub fn raster_of_height(self, fov: f64, resolution: [u32; 2]) -> Result<ViewRaster> {
        let half_height = half_tangent(fov)?;
        let [width, height] = check_resolution(resolution)?;
        let half = DVec2::new(half_height * width / height, half_height);
        ViewRaster::new(self, half, true, resolution)
    }
}

fn half_tangent(fov: f64) -> Result<f64> {
    if (1e-6..=179.999).contains(&fov) {
        let (sin, cos) = libm::sincos((fov / 2.0).to_radians());
        Ok(sin / cos)
    } else {
        Err(Error::Setting { setting: "fov", reason: "must lie between 0 and 180 degrees" })
    }
}

fn check_resolution(resolution: [u32; 2]) -> Result<[f64; 2]> {
    if resolution.iter().all(|side| (1..=65_536).contains(side)) {
        Ok(resolution.map(f64::from))
    } else {
        let reason = "must lie between 1 and 65,536 pixels";
        Err(Error::Setting { setting: "resolution", reason })
    }
}
