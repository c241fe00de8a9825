//! The space in which shadow rays of an area light are straight.

use dsm_core::detail::{LightShape, Result};
use dsm_core::{AreaLight, Error, LightExtent, ShadowCamera};
use glam::{DAffine3, DMat2, DMat3, DVec2, DVec3, DVec4};

use super::shadow_ray::ShadowRay;

/// The frame of a perspective shadow camera that looks past an area light:
/// raster x and y in pixels, and w = 1/depth.
///
/// Perspective keeps lines straight and planes flat in (x, y, w), so that a
/// shadow ray needs no divide a step (Xie et al. 2007, §6.1). The light's
/// centre lies on the camera's axis at depth `light_depth`: 0 where the camera
/// sits in the light, more where it was moved back to see all that any point of
/// the light sees (§6.2, equation 4, [`Self::push_back`]). A map's header needs
/// no more than its camera, its size and that depth.
///
/// ```
/// use dsm_core::ShadowCamera;
/// use glam::{DVec3, DMat4, DVec4};
/// use dsm_trace::detail::LightFrame;
///
/// // At the origin, looking down −z, 90 degrees wide.
/// let to_ndc = DMat4::from_cols(
///     DVec4::new(0.5, 0.0, 0.0, 0.0),
///     DVec4::new(0.0, -0.5, 0.0, 0.0),
///     DVec4::new(-0.5, -0.5, -1.0, -1.0),
///     DVec4::ZERO,
/// );
/// let camera =
///     ShadowCamera { world_to_camera: Some(DMat4::IDENTITY), world_to_ndc: Some(to_ndc) };
/// let frame = LightFrame::new(&camera, [100, 100], 0.5)?;
/// let place = frame.project(DVec3::new(1.0, 0.0, -2.0)).unwrap();
/// assert_eq!(place, DVec3::new(75.0, 50.0, 0.5));
/// assert_eq!(frame.light_centre(), DVec3::new(0.0, 0.0, -0.5));
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightFrame {
    to_camera: DAffine3,
    to_world: DAffine3,
    /// Maps a ray's sideways gain per unit of depth to raster positions.
    linear: DMat2,
    inverse: DMat2,
    offset: DVec2,
    size: [u32; 2],
    light_depth: f64,
}

impl LightFrame {
    /// The frame of `camera`, whose NDC \[0, 1\]² covers a map of `size`
    /// pixels, with the light's centre at `light_depth` on its axis.
    ///
    /// # Errors
    ///
    /// [`Error::Camera`] if a matrix is unknown, or the two don't make a
    /// perspective projection from the camera's place along its axis, as far as
    /// their rounding lets tell ([`ShadowCamera::projection`]);
    /// [`Error::Setting`] if the depth is negative or not finite.
    pub fn new(camera: &ShadowCamera, size: [u32; 2], light_depth: f64) -> Result<Self> {
        let (projection, rounding) = camera.projection()?;
        let to_camera = camera.world_to_camera.unwrap_or_default();
        if !(0.0..f64::INFINITY).contains(&light_depth) {
            let reason = "it must be finite and not negative";
            return Err(Error::Setting { setting: "light depth", reason });
        }
        let [x, y, w] = [0, 1, 3].map(|row| projection.row(row));
        let [off_x, off_y, off_w] = [0, 1, 3].map(|row| rounding.row(row));
        let scale = -w.z;
        if scale.is_nan() || scale <= off_w.z {
            return Err(Error::Camera("rays of an area light need a perspective projection"));
        }
        let raster = DVec2::from(size.map(f64::from));
        let linear = DMat2::from_cols(DVec2::new(x.x, y.x), DVec2::new(x.y, y.y));
        let linear = DMat2::from_diagonal(raster) * linear * scale.recip();
        let offset = -DVec2::new(x.z, y.z) * raster / scale;
        // What is 0 for a pinhole at the camera's place that looks along its axis.
        let stray = [(w, off_w, [0, 1, 3].as_slice()), (x, off_x, &[3]), (y, off_y, &[3])];
        let is_rounding = |(row, off, columns): &(DVec4, DVec4, &[usize])| {
            columns.iter().all(|&column| row[column].abs() <= off[column])
        };
        if !stray.iter().all(is_rounding) {
            let reason = "world-to-NDC does not project from where world-to-camera stands, \
                          along its view axis";
            return Err(Error::Camera(reason));
        }
        let to_camera = DAffine3::from_mat4(to_camera);
        let (to_world, inverse) = (to_camera.inverse(), linear.inverse());
        let columns = [inverse.x_axis, inverse.y_axis, offset];
        if !columns.iter().all(|pair| pair.is_finite()) || !to_world.is_finite() {
            return Err(Error::Camera("the matrices do not make a projection"));
        }
        Ok(Self { to_camera, to_world, linear, inverse, offset, size, light_depth })
    }

    /// The distance by which to move a camera back from the centre of a light so
    /// that, with the same angle, it sees all that any point of the light sees (Xie
    /// et al. 2007, equation 4). `half_size` is half the view's width and height at
    /// depth 1: the tangents of half its angles.
    ///
    /// ```
    /// use dsm_core::LightExtent;
    ///
    /// let light = LightExtent::rectangle([1.0, 0.5]);
    /// assert_eq!(dsm_trace::detail::LightFrame::push_back(light, [0.5, 0.125]), 2.0);
    /// ```
    #[must_use]
    pub fn push_back(light: LightExtent, half_size: [f64; 2]) -> f64 {
        let size = light.size();
        let radii = match light.shape() {
            LightShape::Point => [0.0; 2],
            // A receiver beside a sphere sees its full radius either way.
            LightShape::Sphere => [size[0].max(size[1]) / 2.0; 2],
            _ => size.map(|size| size / 2.0),
        };
        let distance = |axis: usize| {
            if radii[axis] > 0.0 { radii[axis] / half_size[axis] } else { 0.0 }
        };
        distance(0).max(distance(1))
    }

    /// The frame of a camera that stands elsewhere and looks the same way: `offset` is along
    /// this one's right, up and backward axes, in scene units. The light's centre keeps its
    /// depth.
    #[must_use]
    pub fn moved(&self, offset: DVec3) -> Self {
        let to_camera = DAffine3::from_translation(-offset) * self.to_camera;
        let to_world = self.to_world * DAffine3::from_translation(offset);
        Self { to_camera, to_world, ..*self }
    }

    /// Width and height of the map in pixels.
    #[must_use]
    pub const fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The depth of the light's centre, on the camera's axis.
    #[must_use]
    pub const fn light_depth(&self) -> f64 {
        self.light_depth
    }

    /// The light's centre in the world.
    #[must_use]
    pub fn light_centre(&self) -> DVec3 {
        self.to_world.transform_point3(DVec3::new(0.0, 0.0, -self.light_depth))
    }

    /// The camera's right, up and backward axes in the world.
    #[must_use]
    pub const fn basis(&self) -> DMat3 {
        self.to_world.matrix3
    }

    /// The light of this outline and size at the light's centre, along the
    /// camera's axes: what a map's header tells of it.
    #[must_use]
    pub fn area_light(&self, extent: LightExtent) -> AreaLight {
        extent.placed(self.light_centre(), [self.basis().x_axis, self.basis().y_axis])
    }

    /// A point of the world in camera space, with its depth for z: positive in
    /// front of the camera.
    #[must_use]
    pub fn camera_point(&self, world: DVec3) -> DVec3 {
        let point = self.to_camera.transform_point3(world);
        DVec3::new(point.x, point.y, -point.z)
    }

    /// [`Self::camera_point`] of columns of points.
    #[inline(always)]
    pub fn camera_points<const N: usize>(&self, world: &[[f64; N]; 3]) -> [[f64; N]; 3] {
        let (matrix, offset) = (self.to_camera.matrix3, self.to_camera.translation);
        let mut points = [[0.0; N]; 3];
        for (axis, column) in points.iter_mut().enumerate() {
            let sign = if axis == 2 { -1.0 } else { 1.0 };
            let [x, y, z] = [0, 1, 2].map(|of| sign * matrix.col(of)[axis]);
            let offset = sign * offset[axis];
            for lane in 0..N {
                column[lane] =
                    x * world[0][lane] + y * world[1][lane] + z * world[2][lane] + offset;
            }
        }
        points
    }

    /// Raster x and y in pixels, and w, of a point of the world; `None` at the
    /// camera's plane or behind it, and where numbers are not finite.
    #[must_use]
    pub fn project(&self, world: DVec3) -> Option<DVec3> {
        let point = self.camera_point(world);
        let place = self.raster(point).extend(point.z.recip());
        (point.z > 0.0 && place.is_finite()).then_some(place)
    }

    /// The point of the world at raster position (`x`, `y`) and depth.
    #[must_use]
    pub fn unproject(&self, x: f64, y: f64, depth: f64) -> DVec3 {
        let across = self.inverse * (DVec2::new(x, y) - self.offset) * depth;
        self.to_world.transform_point3(across.extend(-depth))
    }

    /// The side of a pixel at `depth`, in scene units: of the square as large
    /// as it. Linear in the depth.
    #[must_use]
    pub fn footprint(&self, depth: f64) -> f64 {
        depth * self.inverse.determinant().abs().sqrt()
    }

    /// w and its gradient per pixel, on the plane through the point at raster
    /// (`x`, `y`) and `depth` with this normal (camera space, right-handed, the
    /// camera looks down −z, any length). `None` if the plane goes through the
    /// camera, or numbers are not finite.
    #[must_use]
    pub fn plane(&self, x: f64, y: f64, depth: f64, normal: DVec3) -> Option<[f64; 2]> {
        let across = self.inverse * (DVec2::new(x, y) - self.offset);
        // n·P = n·P₀ along P = (t, −1)/w with t the sideways gain.
        let distance = depth * (normal.truncate().dot(across) - normal.z);
        let gradient = self.inverse.transpose() * normal.truncate() / distance;
        gradient.is_finite().then_some(gradient.to_array())
    }

    /// The shadow ray from `receiver` to `light`, two points of the world,
    /// without its first `start` scene units. `None` if nothing in the map can
    /// lie between: the receiver is no deeper than the light's centre or than
    /// `light`, it is nearer to it than `start`, or a number is not finite.
    /// Such receivers are lit.
    #[must_use]
    pub fn ray(&self, receiver: DVec3, light: DVec3, start: f64) -> Option<ShadowRay> {
        let (from, to) = (self.camera_point(receiver), self.camera_point(light));
        let share = start / receiver.distance(light);
        if !(from.z > self.light_depth && from.z > to.z && share < 1.0) {
            return None;
        }
        let start = from.lerp(to, share);
        let place = self.raster(start);
        let w = start.z.recip();
        // How far the place moves per unit of w; finite for points of the light
        // in the camera's plane or behind it, too.
        let towards = self.linear * to.truncate() + (self.offset - place) * to.z;
        let slope = towards / (1.0 - w * to.z);
        let end = if to.z > 0.0 { to.z.recip() } else { f64::INFINITY };
        let ray = ShadowRay::new(place.to_array(), w, slope.to_array(), end);
        ray.is_sound().then_some(ray)
    }

    /// The affine map of a point's sideways gain per unit of depth to its raster
    /// position: linear · gain + offset.
    pub const fn raster_map(&self) -> (DMat2, DVec2) {
        (self.linear, self.offset)
    }

    fn raster(&self, point: DVec3) -> DVec2 {
        self.linear * (point.truncate() / point.z) + self.offset
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DMat4;

    fn camera() -> ShadowCamera {
        let turn = DMat4::from_rotation_x(1.1) * DMat4::from_rotation_y(0.4);
        let view = turn * DMat4::from_translation(-DVec3::new(1.0, 5.0, 2.0));
        let to_ndc = DMat4::from_cols(
            DVec4::new(1.5, 0.0, 0.0, 0.0),
            DVec4::new(0.0, -1.0, 0.0, 0.0),
            // Off the axis, as of a portal in a wall.
            DVec4::new(-0.55, -0.45, -1.0, -1.0),
            DVec4::ZERO,
        );
        ShadowCamera { world_to_camera: Some(view), world_to_ndc: Some(to_ndc * view) }
    }

    #[test]
    fn agrees_with_the_camera() {
        let frame = LightFrame::new(&camera(), [60, 40], 0.5).unwrap();
        for world in [DVec3::ZERO, DVec3::new(0.7, 1.0, -0.3), DVec3::new(-2.0, 0.1, 1.0)] {
            let expected = camera().project(world).unwrap().unwrap();
            let place = frame.project(world).unwrap();
            let raster = expected.truncate() * DVec2::new(60.0, 40.0);
            assert!((place.truncate() - raster).length() < 1e-4, "{place} {expected}");
            assert!((place.z - expected.z.recip()).abs() < 1e-6);
            let back = frame.unproject(place.x, place.y, place.z.recip());
            assert!((back - world).length() < 1e-9);
        }
        assert_eq!(frame.project(DVec3::new(1.0, 6.0, 2.0)), None);
        assert!((frame.camera_point(frame.light_centre()) - DVec3::Z * 0.5).length() < 1e-12);
    }

    #[test]
    fn rays_are_straight_and_reach_the_light() {
        let frame = LightFrame::new(&camera(), [60, 40], 0.5).unwrap();
        let receiver = DVec3::new(0.1, 0.2, 0.3);
        // Before the camera's plane, in it, and behind it.
        for depth in [0.75, 0.5, 0.0, -0.25] {
            let light = frame.to_world.transform_point3(DVec3::new(0.4, -0.2, -depth));
            let ray = frame.ray(receiver, light, 0.0).unwrap();
            for share in [0.0, 0.25, 0.8] {
                let point = receiver.lerp(light, share);
                let place = frame.project(point).unwrap();
                let at = ray.at(place.z);
                let there = DVec2::from(at);
                assert!((there - place.truncate()).length() < 1e-9, "{there} {place}");
            }
            let end = if depth > 0.0 { depth.recip() } else { f64::INFINITY };
            assert!((ray.range()[1] - end).abs() < 1e-9 || ray.range()[1] == end);
            let later = frame.ray(receiver, light, 0.5).unwrap();
            let start = receiver + (light - receiver).normalize() * 0.5;
            assert!((later.range()[0] - frame.project(start).unwrap().z).abs() < 1e-12);
        }
    }

    #[test]
    fn what_lies_beside_the_light_is_lit() {
        let frame = LightFrame::new(&camera(), [60, 40], 0.5).unwrap();
        let light = frame.light_centre();
        let at = |depth: f64| frame.to_world.transform_point3(DVec3::new(0.1, 0.1, -depth));
        assert!(frame.ray(at(0.499_999), light, 0.0).is_none());
        assert!(frame.ray(at(0.25), light, 0.0).is_none());
        assert!(frame.ray(at(-1.0), light, 0.0).is_none());
        assert!(frame.ray(at(0.75), at(0.8), 0.0).is_none(), "a light behind the receiver");
        assert!(frame.ray(at(2.0), light, 3.0).is_none(), "the start lies behind the light");
        assert!(frame.ray(at(2.0), light, f64::NAN).is_none());
        assert!(frame.ray(DVec3::NAN, light, 0.0).is_none());
        assert!(frame.ray(at(2.0), DVec3::NAN, 0.0).is_none());
        assert!(frame.ray(DVec3::INFINITY, light, 0.0).is_none());
        assert!(frame.ray(at(0.75), light, 0.0).is_some());
    }

    #[test]
    fn planes_keep_their_gradients() {
        let frame = LightFrame::new(&camera(), [60, 40], 0.0).unwrap();
        let normal = DVec3::new(0.3, -0.5, 0.8);
        let [x, y, depth] = [20.0, 13.0, 4.0];
        let through = frame.camera_point(frame.unproject(x, y, depth));
        let [along_x, along_y] = frame.plane(x, y, depth, normal).unwrap();
        for (dx, dy) in [(1.0, 0.0), (0.0, 1.0), (-3.0, 2.0)] {
            let w = depth.recip() + along_x * dx + along_y * dy;
            let point = frame.camera_point(frame.unproject(x + dx, y + dy, w.recip()));
            let off = (point - through) * DVec3::new(1.0, 1.0, -1.0);
            assert!(off.dot(normal).abs() < 1e-9, "{off}");
        }
        let facing = frame.plane(x, y, depth, DVec3::Z).unwrap();
        assert_eq!(facing, [0.0; 2]);
        let edge_on = frame.unproject(x, y, 1.0);
        let edge_on = frame.camera_point(edge_on).cross(DVec3::X) * DVec3::new(1.0, 1.0, -1.0);
        assert!(frame.plane(x, y, depth, edge_on).is_none_or(|g| g[1].abs() > 1e9));
        assert_eq!(frame.plane(x, y, depth, DVec3::NAN), None);
    }

    #[test]
    fn what_is_no_perspective_is_refused() {
        let good = camera();
        let flat = DMat4::from_cols(DVec4::X, DVec4::Y, DVec4::Z, DVec4::new(0.5, 0.5, 0.0, 1.0));
        for world_to_ndc in [None, Some(DMat4::ZERO), Some(DMat4::NAN), Some(flat)] {
            let camera = ShadowCamera { world_to_ndc, ..good };
            assert!(LightFrame::new(&camera, [8, 8], 0.0).is_err(), "{world_to_ndc:?}");
        }
        let beside = DMat4::from_translation(DVec3::X);
        let world_to_camera = good.world_to_camera.map(|matrix| beside * matrix);
        assert!(LightFrame::new(&ShadowCamera { world_to_camera, ..good }, [8, 8], 0.0).is_err());
        for depth in [-1.0, f64::NAN, f64::INFINITY] {
            assert!(LightFrame::new(&good, [8, 8], depth).is_err());
        }
    }

    /// [`camera`] in a world that is `scale` times as large, and shifted.
    fn placed(scale: f64, shift: DVec3) -> ShadowCamera {
        let back = DMat4::from_translation(-shift);
        let ShadowCamera { world_to_camera, world_to_ndc } = camera();
        let small = DMat4::from_scale(DVec3::splat(scale.recip()));
        let large = DMat4::from_scale(DVec3::splat(scale));
        ShadowCamera {
            world_to_camera: world_to_camera.map(|matrix| large * matrix * small * back),
            world_to_ndc: world_to_ndc.map(|matrix| matrix * small * back),
        }
    }

    #[test]
    fn places_and_sizes_of_the_world_do_not_matter() {
        let frame = LightFrame::new(&camera(), [60, 40], 0.5).unwrap();
        let point = DVec3::new(0.7, 1.0, -0.3);
        let place = frame.project(point).unwrap();
        for scale in [1e-6, 1e-3, 1.0, 44.0, 1e6] {
            for radii in [0.0, 150.0, 1e4] {
                let shift = DVec3::new(0.6, -0.5, 0.62) * (radii * scale);
                let camera = placed(scale, shift);
                let there = LightFrame::new(&camera, [60, 40], 0.5 * scale).unwrap();
                let found = there.project(point * scale + shift).unwrap();
                assert!((found.truncate() - place.truncate()).length() < 1e-9, "{scale} {radii}");
                assert!((found.z * scale - place.z).abs() < 1e-11);
                // As a deep image carries it, the camera is known to some 2⁻²² of its way.
                let single = |matrix: Option<DMat4>| matrix.map(|m| m.as_mat4().as_dmat4());
                let rounded = ShadowCamera {
                    world_to_camera: single(camera.world_to_camera),
                    world_to_ndc: single(camera.world_to_ndc),
                };
                let there = LightFrame::new(&rounded, [60, 40], 0.5 * scale).unwrap();
                let found = there.project(point * scale + shift).unwrap();
                let off = (found.truncate() - place.truncate()).length();
                assert!(off < 60.0 * (10.0 + radii) / f64::from(1 << 22), "{scale} {radii}: {off}");
                // A stereo camera beside it is another one.
                let beside = DMat4::from_translation(DVec3::X * (0.05 * scale));
                let beside = camera.world_to_camera.map(|matrix| beside * matrix);
                let other = ShadowCamera { world_to_camera: beside, ..camera };
                assert!(LightFrame::new(&other, [60, 40], 0.0).is_err(), "{scale} {radii}");
            }
        }
    }

    #[test]
    fn the_header_gives_the_light_back() {
        let frame = LightFrame::new(&camera(), [60, 40], 0.5).unwrap();
        for extent in
            [LightExtent::POINT, LightExtent::rectangle([1.5, 0.5]), LightExtent::disk(0.75)]
        {
            let light = frame.area_light(extent);
            assert_eq!(light.shape(), extent.shape());
            for (have, want) in light.extent().size().into_iter().zip(extent.size()) {
                assert!((have - want).abs() < 1e-6);
            }
            assert!((light.centre() - frame.light_centre()).length() < 1e-12);
        }
        let sphere = LightExtent::sphere(1.0);
        assert!((frame.area_light(sphere).extent().size()[0] - 2.0).abs() < 1e-6);
        assert_eq!(LightFrame::push_back(sphere, [0.5, 1.0]), 2.0);
        let point = LightExtent::POINT;
        assert_eq!(LightFrame::push_back(point, [0.5, 1.0]), 0.0);
    }
}
