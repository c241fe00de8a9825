//! The pixels of a view.

use glam::{DMat3, DMat4, DVec2, DVec3, DVec4};

use super::ray::Ray;
use super::shadow_camera::ShadowCamera;
use super::view::View;
use crate::error::Result;

/// A view over pixels: x right, y down, pixel (i, j) covers [i, i + 1) ×
/// [j, j + 1).
///
/// ```
/// use dsm_core::{Projection, View};
/// use glam::DVec3;
///
/// let view = View { eye: DVec3::Z * 5.0, target: DVec3::ZERO, up: DVec3::Y };
/// let raster = view.raster(Projection::Perspective { fov: 90.0 }, [64, 32])?;
/// // The upper left corner of the wide map; the wider side has the angle.
/// let ray = raster.ray(0.0, 0.0, 0.0);
/// assert!((ray.at(5.0) - DVec3::new(-5.0, 2.5, 0.0)).length() < 1e-12);
/// // Its parameter is the depth, not the distance.
/// let projected = raster.shadow_camera().project(ray.at(5.0))?.unwrap();
/// assert!((projected - DVec3::new(0.0, 0.0, 5.0)).length() < 1e-6);
/// # Ok::<(), dsm_core::Error>(())
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
    pub(super) fn new(
        view: View,
        half: DVec2,
        perspective: bool,
        resolution: [u32; 2],
    ) -> Result<Self> {
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

    /// True if rays go through one point.
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

    /// This view from `distance` further back, its angle unchanged.
    #[must_use]
    pub fn moved_back(&self, distance: f64) -> Self {
        Self { eye: self.eye + self.basis.z_axis * distance, ..*self }
    }

    /// This view from another place: it looks the same way, and is as wide.
    #[must_use]
    pub fn at_eye(&self, eye: DVec3) -> Self {
        Self { eye, ..*self }
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

    /// The raster position and the depth of a point of the world; `None` at the
    /// camera's plane, behind it, and where numbers are not finite. The inverse of
    /// [`Self::ray`].
    #[must_use]
    pub fn project(&self, world: DVec3) -> Option<DVec3> {
        let point = self.basis.transpose() * (world - self.eye);
        let depth = -point.z;
        let scale = if self.perspective { depth } else { 1.0 };
        let across = point.truncate() / (self.half * scale) * DVec2::new(0.5, -0.5) + 0.5;
        let place = (across * DVec2::from(self.resolution.map(f64::from))).extend(depth);
        (depth > 0.0 && place.is_finite()).then_some(place)
    }

    /// The shadow camera of a map from this view.
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
