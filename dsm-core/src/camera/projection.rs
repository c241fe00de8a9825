//! Raster positions of world points in a map, and their derivatives.

use glam::{DMat2, DMat4, DVec2, DVec3};

use super::map_info::MapInfo;
use super::pixel_window::PixelWindow;
use super::shadow_camera::ShadowCamera;
use crate::error::{Error, Result};

/// The projection of world points to a map's raster: pixel (i, j) covers [i, i+1) ×
/// [j, j+1), and z is the depth.
///
/// ```
/// use dsm_core::{MapInfo, ShadowCamera};
/// use dsm_core::detail::MapProjection;
/// use glam::{DMat4, DVec3, DVec4};
///
/// // Looks down −z from the origin; NDC covers [−1, 1]², y up.
/// let ndc = DMat4::from_rows(
///     DVec4::new(0.5, 0.0, 0.0, 0.5),
///     DVec4::new(0.0, -0.5, 0.0, 0.5),
///     DVec4::Z,
///     DVec4::W,
/// );
/// let camera = ShadowCamera { world_to_camera: Some(DMat4::IDENTITY), world_to_ndc: Some(ndc) };
/// let info = MapInfo::new().with_camera(camera);
/// let projection = MapProjection::new(&info, [64, 64])?;
/// let raster = projection.project(DVec3::new(-1.0, 1.0, -3.0));
/// assert_eq!(raster, Some(DVec3::new(0.0, 0.0, 3.0)));
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct MapProjection {
    camera: ShadowCamera,
    to_camera: DMat4,
    to_ndc: DMat4,
    /// Pixels that NDC [0, 1]² covers: the display window's size.
    scale: DVec2,
    /// The display window's corner, seen from the map's.
    corner: DVec2,
}

impl MapProjection {
    /// The projection into a map of `size` pixels. A window that the map doesn't
    /// know is the map itself.
    ///
    /// # Errors
    ///
    /// [`Error::Camera`] if the map has no camera, or one without a matrix.
    pub fn new(info: &MapInfo, size: [u32; 2]) -> Result<Self> {
        let camera = info.camera.ok_or(Error::Camera("the map has none"))?;
        let (to_camera, to_ndc) = camera.matrices()?;
        let known = |window: Option<PixelWindow>| window.filter(|w| !w.size().contains(&0));
        let display = known(info.display_window).or(known(info.data_window));
        let scale = display.map_or(size.map(f64::from), |window| window.size().map(|n| n as f64));
        let corner = match (known(info.display_window), info.data_window) {
            (Some(display), Some(data)) => {
                [0, 1].map(|axis| f64::from(display.min[axis]) - f64::from(data.min[axis]))
            }
            _ => [0.0; 2],
        };
        Ok(Self { camera, to_camera, to_ndc, scale: scale.into(), corner: corner.into() })
    }

    /// The raster position and depth of a point of the world; `None` behind
    /// the camera and where the projection is not finite.
    #[must_use]
    pub fn project(&self, world: DVec3) -> Option<DVec3> {
        // Only a matrix that is missing is an error, and none is.
        let ndc = self.camera.project(world).ok()??;
        Some((self.corner + ndc.truncate() * self.scale).extend(ndc.z))
    }

    /// The derivatives of the raster position and the depth of a point of the world
    /// along each of two directions, per unit of length.
    fn changes(&self, world: DVec3, directions: [DVec3; 2]) -> [DVec3; 2] {
        let projected = self.to_ndc * world.extend(1.0);
        directions.map(|direction| {
            let moved = self.to_ndc * direction.extend(0.0);
            let ndc = projected.truncate().truncate() / projected.w;
            let ndc = (moved.truncate().truncate() - ndc * moved.w) / projected.w;
            let depth = -self.to_camera.transform_vector3(direction).z;
            (ndc * self.scale).extend(depth)
        })
    }

    /// The size of a pixel in the world, across the view axis, at a point: the side
    /// of a square of the same area, in scene units.
    pub(crate) fn pixel_size(&self, world: DVec3) -> f64 {
        self.image_plane(world).abs().sqrt().recip()
    }

    /// The area in pixels of a square across the view axis, of side 1, at a
    /// point: negative, because y points down.
    fn image_plane(&self, world: DVec3) -> f64 {
        // Rows of the rotation: the camera's right and up in the world.
        let axes = [0, 1].map(|axis| self.to_camera.row(axis).truncate());
        let [right, up] = self.changes(world, axes).map(DVec3::truncate);
        DMat2::from_cols(right, up).determinant()
    }

    /// The change of depth per pixel in x and y of a plane with this unit normal at
    /// a point, and true if the camera is on the side that the normal points to;
    /// `None` where the plane is seen edge on.
    pub(crate) fn plane_gradient(&self, world: DVec3, normal: DVec3) -> Option<(DVec2, bool)> {
        let u = normal.any_orthogonal_vector().try_normalize()?;
        let [u, v] = self.changes(world, [u, normal.cross(u)]);
        let across = DMat2::from_cols(u.truncate(), v.truncate());
        let gradient = across.transpose().inverse() * DVec2::new(u.z, v.z);
        let faces = across.determinant() * self.image_plane(world) > 0.0;
        gradient.is_finite().then_some((gradient, faces))
    }

    /// The change of depth per pixel along a line, as a gradient that points the
    /// way the line is seen; `None` for a line that is seen as a point.
    pub(crate) fn line_gradient(&self, world: DVec3, along: DVec3) -> Option<DVec2> {
        let [change, _] = self.changes(world, [along; 2]);
        let across = change.truncate();
        let gradient = across * (change.z / across.length_squared());
        gradient.is_finite().then_some(gradient)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec4;

    /// Looks down −z from the origin; NDC covers [−1, 1]², y up.
    fn info() -> MapInfo {
        let ndc = DMat4::from_rows(
            DVec4::new(0.5, 0.0, 0.0, 0.5),
            DVec4::new(0.0, -0.5, 0.0, 0.5),
            DVec4::Z,
            DVec4::W,
        );
        let camera =
            ShadowCamera { world_to_camera: Some(DMat4::IDENTITY), world_to_ndc: Some(ndc) };
        MapInfo::new().with_camera(camera)
    }

    fn project(info: &MapInfo, world: [f64; 3]) -> Option<[f64; 3]> {
        let raster = MapProjection::new(info, [10, 20]).unwrap();
        raster.project(world.into()).map(Into::into)
    }

    #[test]
    fn ndc_covers_the_display_window() {
        let upper_left = [-1.0, 1.0, -3.0];
        assert_eq!(project(&info(), upper_left), Some([0.0, 0.0, 3.0]));
        assert_eq!(project(&info(), [0.5, -1.0, -3.0]), Some([7.5, 20.0, 3.0]));
        let data = Some(PixelWindow { min: [5, 6], max: [14, 25] });
        let display = Some(PixelWindow { min: [1, -2], max: [100, 97] });
        let info = MapInfo { data_window: data, display_window: display, ..info() };
        assert_eq!(project(&info, upper_left), Some([-4.0, -8.0, 3.0]));
        assert_eq!(project(&info, [1.0, -1.0, -3.0]), Some([96.0, 92.0, 3.0]));
        let info = MapInfo { display_window: None, ..info };
        assert_eq!(project(&info, upper_left), Some([0.0, 0.0, 3.0]));
    }

    #[test]
    fn behind_the_camera_is_nowhere() {
        assert_eq!(project(&info(), [0.0, 0.0, 1.0]), None);
        assert_eq!(project(&info(), [f64::NAN, 0.0, -1.0]), None);
    }

    #[test]
    fn a_map_needs_a_whole_camera() {
        let refused = |info: &MapInfo| MapProjection::new(info, [10, 20]).unwrap_err().to_string();
        assert!(refused(&MapInfo::default()).contains("has none"));
        let half = ShadowCamera { world_to_ndc: None, ..info().camera.unwrap() };
        assert!(refused(&info().with_camera(half)).contains("NDC"));
    }

    #[test]
    fn gradients_are_those_of_depths_a_pixel_apart() {
        // Off the axis of a camera that is turned and stands elsewhere.
        let view = DMat4::from_rotation_x(0.9)
            * DMat4::from_rotation_y(0.3)
            * DMat4::from_translation(DVec3::new(-1.0, -4.0, -2.0));
        let ndc = info().camera.unwrap().world_to_ndc.unwrap();
        let perspective = DMat4::from_cols(
            ndc.x_axis,
            ndc.y_axis,
            DVec4::new(-0.5, -0.5, 1.0, -1.0),
            DVec4::ZERO,
        );
        for ndc in [ndc, perspective] {
            let camera =
                ShadowCamera { world_to_camera: Some(view), world_to_ndc: Some(ndc * view) };
            let info = MapInfo::new().with_camera(camera);
            let projection = MapProjection::new(&info, [100, 80]).unwrap();
            let (point, normal) =
                (DVec3::new(0.3, 0.4, -0.5), DVec3::new(0.3, 0.9, 0.1).normalize());
            let at = projection.project(point).unwrap();
            let (gradient, faces) = projection.plane_gradient(point, normal).unwrap();
            let (_, back) = projection.plane_gradient(point, -normal).unwrap();
            assert!(faces && !back);
            let (u, v) = normal.any_orthonormal_pair();
            for step in [u, v, u - v].map(|step| step * 1e-4) {
                let moved = projection.project(point + step).unwrap() - at;
                let expected = gradient.dot(moved.truncate());
                assert!((moved.z - expected).abs() < 1e-6, "{} {expected}", moved.z);
                let along = projection.line_gradient(point, step.normalize()).unwrap();
                assert!((moved.z - along.dot(moved.truncate())).abs() < 1e-6);
            }
            let [right, up] = [0, 1].map(|axis| view.row(axis).truncate());
            let side = projection.pixel_size(point);
            let moved = [right, up].map(|axis| {
                (projection.project(point + axis * side).unwrap() - at).truncate().length()
            });
            // Pixels here are not square; their mean side is the geometric.
            assert!((moved[0] * moved[1] - 1.0).abs() < 1e-2, "{moved:?}");
        }
    }
}
