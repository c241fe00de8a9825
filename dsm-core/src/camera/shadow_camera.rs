//! Where a map looks from, and what its depths mean.

use glam::{DMat4, DVec3, DVec4, Mat4};
use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

/// What a depth measures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum DepthKind {
    /// Distance from the camera's plane, along the view axis.
    #[default]
    Planar,
}

/// A shadow camera, by the two matrices that deep OpenEXR files carry.
///
/// Column vectors, right-handed world; the camera looks down its −z, so that
/// depth is −z of camera space. NDC is [0, 1]², x right and y down, over the
/// display window. Either matrix may be unknown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ShadowCamera {
    /// World to camera space.
    pub world_to_camera: Option<Mat4>,
    /// World to NDC, up to the perspective divide.
    pub world_to_ndc: Option<Mat4>,
}

impl ShadowCamera {
    pub(crate) fn matrices(&self) -> Result<(DMat4, DMat4)> {
        match (self.world_to_camera, self.world_to_ndc) {
            (Some(camera), Some(ndc)) => Ok((camera.as_dmat4(), ndc.as_dmat4())),
            (None, _) => Err(Error::Camera("the world-to-camera matrix is unknown")),
            (_, None) => Err(Error::Camera("the world-to-NDC matrix is unknown")),
        }
    }

    /// Projects a point of the world: its NDC x and y, and its depth. `None`
    /// behind the camera and where the projection is not finite.
    ///
    /// # Errors
    ///
    /// [`Error::Camera`] if a matrix is unknown.
    pub fn project(&self, world: DVec3) -> Result<Option<DVec3>> {
        let (camera, ndc) = self.matrices()?;
        let depth = -camera.transform_point3(world).z;
        let projected: DVec4 = ndc * world.extend(1.0);
        let point = DVec3::new(projected.x / projected.w, projected.y / projected.w, depth);
        Ok((depth > 0.0 && projected.w > 0.0 && point.is_finite()).then_some(point))
    }

    /// The distance along the ray through NDC point (`x`, `y`) per unit of
    /// depth: 1 for orthographic cameras, more off the axis of a perspective
    /// one. Volume integrals need it (Lokovic & Veach 2000, footnote 3).
    ///
    /// # Errors
    ///
    /// [`Error::Camera`] if a matrix is unknown or the two don't make a
    /// projection.
    pub fn distance_per_depth(&self, x: f64, y: f64) -> Result<f64> {
        let factor = RayDirections::new(self)?.distance_per_depth(x, y);
        if factor.is_finite() {
            Ok(factor)
        } else {
            Err(Error::Camera("the matrices do not make a projection"))
        }
    }
}

/// Where a camera's rays go: what [`ShadowCamera::distance_per_depth`] needs of
/// its matrices, for many rays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RayDirections {
    /// Of the projection from camera space: its rows for x, y and w, without
    /// the last column.
    rows: [DVec3; 3],
}

impl RayDirections {
    /// The rays of `camera`.
    pub(crate) fn new(camera: &ShadowCamera) -> Result<Self> {
        let (camera, ndc) = camera.matrices()?;
        let projection = ndc * camera.inverse();
        Ok(Self { rows: [0, 1, 3].map(|row| projection.row(row).truncate()) })
    }

    /// The distance along the ray through NDC point (`x`, `y`) per unit of
    /// depth, at least 1; not finite if the matrices don't make a projection.
    pub(crate) fn distance_per_depth(&self, x: f64, y: f64) -> f64 {
        let [row_x, row_y, row_w] = self.rows;
        // The ray is where the planes of its x and its y meet: their normals'
        // cross product.
        let direction = (row_x - row_w * x).cross(row_y - row_w * y);
        let factor = direction.length() / direction.z.abs();
        if factor < 1.0 { 1.0 } else { factor }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec3, Vec4};

    const PERSPECTIVE: f32 = 1.0;
    const ORTHOGRAPHIC: f32 = 0.0;

    /// A camera at (1, 2, 5) that looks down −z. Perspective: 90 degrees wide;
    /// orthographic: 2 units wide.
    fn camera(perspective: f32) -> ShadowCamera {
        let view = Mat4::from_translation(Vec3::new(-1.0, -2.0, -5.0));
        let projection = Mat4::from_rows(
            Vec4::new(0.5, 0.0, -0.5 * perspective, 0.5 * (1.0 - perspective)),
            Vec4::new(0.0, -0.5, -0.5 * perspective, 0.5 * (1.0 - perspective)),
            Vec4::Z,
            Vec4::new(0.0, 0.0, -perspective, 1.0 - perspective),
        );
        ShadowCamera { world_to_camera: Some(view), world_to_ndc: Some(projection * view) }
    }

    #[test]
    fn a_perspective_ray_is_longer_than_its_depth() {
        let camera = camera(PERSPECTIVE);
        assert!((camera.distance_per_depth(0.5, 0.5).unwrap() - 1.0).abs() < 1e-6);
        // At the right edge of a 90 degree view the ray runs at 45 degrees.
        assert!((camera.distance_per_depth(1.0, 0.5).unwrap() - 2_f64.sqrt()).abs() < 1e-6);
        let projected = camera.project(DVec3::new(1.0, 2.0, 3.0)).unwrap().unwrap();
        assert!((projected - DVec3::new(0.5, 0.5, 2.0)).length() < 1e-6);
        let lower_right = camera.project(DVec3::new(3.0, 0.0, 3.0)).unwrap().unwrap();
        assert!((lower_right - DVec3::new(1.0, 1.0, 2.0)).length() < 1e-6);
    }

    #[test]
    fn an_orthographic_ray_is_as_long_as_its_depth() {
        let camera = camera(ORTHOGRAPHIC);
        assert_eq!(camera.distance_per_depth(0.9, 0.1).unwrap(), 1.0);
    }

    #[test]
    fn behind_the_camera_is_nowhere() {
        let camera = camera(PERSPECTIVE);
        assert_eq!(camera.project(DVec3::new(1.0, 2.0, 6.0)).unwrap(), None);
    }

    #[test]
    fn half_a_camera_is_an_error() {
        let whole = camera(PERSPECTIVE);
        let half = ShadowCamera { world_to_ndc: None, ..whole };
        assert!(half.project(DVec3::ZERO).is_err());
        let flat = ShadowCamera { world_to_ndc: Some(Mat4::ZERO), ..whole };
        assert!(flat.distance_per_depth(0.5, 0.5).is_err());
    }
}
