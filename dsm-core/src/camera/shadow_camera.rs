//! Shadow cameras, and the measure of their depths.

use glam::{DMat4, DVec3, DVec4};
use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

/// The measure of a depth.
///
/// ```
/// use dsm_core::detail::DepthKind;
/// use dsm_core::MapInfo;
///
/// assert_eq!(MapInfo::default().depth_kind, DepthKind::Planar);
/// ```
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
/// display window. Either matrix may be unknown. Matrices of `f32`, as images
/// carry them, are held as they are: [`Self::projection`] tells what they are off by.
///
/// ```
/// use dsm_core::{Projection, View};
/// use glam::DVec3;
///
/// let view = View { eye: DVec3::Z * 5.0, target: DVec3::ZERO, up: DVec3::Y };
/// let raster = view.raster(Projection::Perspective { fov: 90.0 }, [64, 64])?;
/// let camera = raster.shadow_camera();
/// // The middle of the map, 5 units from the camera's plane.
/// let seen = camera.project(DVec3::ZERO)?.unwrap();
/// assert!((seen - DVec3::new(0.5, 0.5, 5.0)).length() < 1e-12);
/// assert_eq!(camera.project(DVec3::Z * 6.0)?, None);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ShadowCamera {
    /// World to camera space.
    pub world_to_camera: Option<DMat4>,
    /// World to NDC, up to the perspective divide.
    pub world_to_ndc: Option<DMat4>,
}

impl ShadowCamera {
    pub(crate) fn matrices(&self) -> Result<(DMat4, DMat4)> {
        match (self.world_to_camera, self.world_to_ndc) {
            (Some(camera), Some(ndc)) => Ok((camera, ndc)),
            (None, _) => Err(Error::Camera("the world-to-camera matrix is unknown")),
            (_, None) => Err(Error::Camera("the world-to-NDC matrix is unknown")),
        }
    }

    /// The matrix from camera space to NDC, up to the perspective divide, and how far
    /// each of its entries may be off, because the numbers of both matrices are
    /// rounded: by 2⁻²⁴ of themselves if all of them are `f32`, by 2⁻⁵³ otherwise.
    ///
    /// The second matrix has the first one's units, so that what should be 0 can be
    /// told from what is not wherever the camera stands and however large a unit is.
    /// It is ∞ or NaN if the camera's matrix has no inverse.
    ///
    /// ```
    /// use dsm_core::ShadowCamera;
    /// use glam::{DMat4, DVec3};
    ///
    /// let view = DMat4::from_translation(DVec3::new(0.0, 0.0, -1e6));
    /// let camera = ShadowCamera { world_to_camera: Some(view), world_to_ndc: Some(view) };
    /// let (projection, rounding) = camera.projection()?;
    /// assert_eq!(projection, DMat4::IDENTITY);
    /// // A million units away, `f32` tell places to about a unit.
    /// assert!((0.1..10.0).contains(&rounding.w_axis.z));
    /// assert!(rounding.x_axis.x < 1e-6);
    /// # Ok::<(), dsm_core::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Camera`] if a matrix is unknown.
    pub fn projection(&self) -> Result<(DMat4, DMat4)> {
        let (camera, ndc) = self.matrices()?;
        let inverse = camera.inverse();
        let numbers = [camera, ndc].map(|matrix| matrix.to_cols_array());
        let is_single = numbers.as_flattened().iter().all(|&number| is_single(number));
        let rounding = if is_single { f64::from(f32::EPSILON) } else { f64::EPSILON } / 2.0;
        // δ(N·C⁻¹) ≤ |δN|·|C⁻¹| + |N|·|C⁻¹|·|δC|·|C⁻¹|; a row times a column has
        // four products, and whoever made the matrices rounded each.
        let across = ndc.abs() * inverse.abs();
        let off = (across + across * (camera.abs() * inverse.abs())) * (4.0 * rounding);
        Ok((ndc * inverse, off))
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

/// The directions of a camera's rays: the matrices of
/// [`ShadowCamera::distance_per_depth`], prepared for many rays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RayDirections {
    /// The x, y and w rows of the projection from camera space, without the last
    /// column.
    rows: [DVec3; 3],
}

impl RayDirections {
    /// The rays of `camera`.
    pub(crate) fn new(camera: &ShadowCamera) -> Result<Self> {
        let (projection, _) = camera.projection()?;
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

/// True for an `f32`, or the number that the shortest decimals of one read as.
fn is_single(number: f64) -> bool {
    let single = number as f32;
    f64::from(single) == number || single.to_string().parse() == Ok(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERSPECTIVE: f64 = 1.0;
    const ORTHOGRAPHIC: f64 = 0.0;

    /// A camera at (1, 2, 5) that looks down −z. Perspective: 90 degrees wide;
    /// orthographic: 2 units wide.
    fn camera(perspective: f64) -> ShadowCamera {
        let view = DMat4::from_translation(DVec3::new(-1.0, -2.0, -5.0));
        let projection = DMat4::from_rows(
            DVec4::new(0.5, 0.0, -0.5 * perspective, 0.5 * (1.0 - perspective)),
            DVec4::new(0.0, -0.5, -0.5 * perspective, 0.5 * (1.0 - perspective)),
            DVec4::Z,
            DVec4::new(0.0, 0.0, -perspective, 1.0 - perspective),
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
    fn rounding_is_that_of_the_numbers_at_hand() {
        // A tenth of a unit beside its pinhole, a thousand units out: an f32 can
        // tell, and a twentieth of a millimetre it cannot.
        let away = DMat4::from_translation(DVec3::new(1000.0 / 3.0, 0.0, 1000.0));
        let good = camera(PERSPECTIVE);
        let moved = |matrix: Option<DMat4>| matrix.map(|matrix| matrix * away);
        let far = ShadowCamera {
            world_to_camera: moved(good.world_to_camera),
            world_to_ndc: moved(good.world_to_ndc),
        };
        let single = |matrix: Option<DMat4>| matrix.map(|matrix| matrix.as_mat4().as_dmat4());
        let rounded = ShadowCamera {
            world_to_camera: single(far.world_to_camera),
            world_to_ndc: single(far.world_to_ndc),
        };
        let decimals = |matrix: Option<DMat4>| {
            let read = |number: f64| (number as f32).to_string().parse().unwrap();
            matrix.map(|matrix| DMat4::from_cols_array(&matrix.to_cols_array().map(read)))
        };
        let written = ShadowCamera {
            world_to_camera: decimals(far.world_to_camera),
            world_to_ndc: decimals(far.world_to_ndc),
        };
        let off = |camera: ShadowCamera| {
            let (projection, rounding) = camera.projection().unwrap();
            (projection.w_axis.x.abs(), rounding.w_axis.x)
        };
        for camera in [rounded, written] {
            let (off, most) = off(camera);
            assert!(off > 1e-9 && off <= most && (5e-5..5e-3).contains(&most), "{off} {most}");
        }
        let (off, most) = off(far);
        assert!(off <= most && most < 1e-11, "{off} {most}");
        assert!(is_single(0.1_f32.into()) && is_single(0.1) && !is_single(0.1 + 1e-12));
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
        let flat = ShadowCamera { world_to_ndc: Some(DMat4::ZERO), ..whole };
        assert!(flat.distance_per_depth(0.5, 0.5).is_err());
    }
}
