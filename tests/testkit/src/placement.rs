//! Placement of a scene: its position and the size of its unit.

use dsm_core::detail::LightShape;
use dsm_core::{AreaLight, Facing, ShadedPoint, ShadowCamera};
use glam::{DMat4, DVec3};

/// A similarity of the world: points are scaled about the origin, then shifted.
///
/// ```
/// use dsm_testkit::Placement;
/// use glam::DVec3;
///
/// let placement = Placement::new(10.0, DVec3::X);
/// assert_eq!(placement.point(DVec3::Y), DVec3::new(1.0, 10.0, 0.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    scale: f64,
    shift: DVec3,
}

impl Placement {
    /// The scene as it is.
    pub const HERE: Self = Self { scale: 1.0, shift: DVec3::ZERO };

    /// Scaled about the origin by `scale` > 0, then moved by `shift`.
    #[must_use]
    pub const fn new(scale: f64, shift: DVec3) -> Self {
        Self { scale, shift }
    }

    /// A scene of this radius moved by 150 and 10⁴ radii, in directions that no axis or
    /// power of two helps with, and scaled by 10⁻⁴ to 10⁴.
    pub fn elsewhere(radius: f64) -> impl Iterator<Item = Self> {
        let places = [
            (1.0, 150.0, [0.48, -0.6, 0.64]),
            (1.0, 1e4, [-0.31, 0.82, 0.48]),
            (1e-4, 0.0, [0.0; 3]),
            (3e-3, 150.0, [0.36, 0.48, -0.8]),
            (44.0, 0.0, [0.0; 3]),
            (1e4, 1e4, [0.73, 0.44, -0.53]),
            (1e-4, 1e4, [-0.8, -0.37, 0.47]),
        ];
        places.into_iter().map(move |(scale, radii, direction)| {
            Self::new(scale, DVec3::from(direction).normalize_or_zero() * (radii * radius * scale))
        })
    }

    /// The scale factor.
    #[must_use]
    pub const fn scale(&self) -> f64 {
        self.scale
    }

    /// The translation, applied after the scale.
    #[must_use]
    pub const fn shift(&self) -> DVec3 {
        self.shift
    }

    /// The matrix.
    #[must_use]
    pub fn matrix(&self) -> DMat4 {
        DMat4::from_translation(self.shift) * DMat4::from_scale(DVec3::splat(self.scale))
    }

    /// The placed position of a point of the scene.
    #[must_use]
    pub fn point(&self, point: DVec3) -> DVec3 {
        point * self.scale + self.shift
    }

    /// The placed receiver.
    #[must_use]
    pub fn shaded(&self, point: &ShadedPoint) -> ShadedPoint {
        ShadedPoint { position: self.point(point.position), ..*point }
    }

    /// A receiver that faces the light, with a seed of its own.
    #[must_use]
    pub const fn receiver(position: DVec3, seed: u64) -> ShadedPoint {
        ShadedPoint { position, facing: Facing::Light, seed }
    }

    /// The placed light.
    #[must_use]
    pub fn light(&self, light: &AreaLight) -> AreaLight {
        let centre = self.point(light.centre());
        let [right, up] = light.half_axes().map(|axis| axis * self.scale);
        match light.shape() {
            LightShape::Rectangle => AreaLight::rectangle(centre, right, up),
            LightShape::Disk => AreaLight::disk(centre, right, up),
            LightShape::Sphere => AreaLight::sphere(centre, right.length()),
            _ => AreaLight::point(centre),
        }
    }

    /// A camera that sees of the placed scene what `camera` saw: its depths are scaled.
    #[must_use]
    pub fn camera(&self, camera: &ShadowCamera) -> ShadowCamera {
        let back = self.matrix().inverse();
        let scale = DMat4::from_scale(DVec3::splat(self.scale));
        ShadowCamera {
            world_to_camera: camera.world_to_camera.map(|matrix| scale * matrix * back),
            world_to_ndc: camera.world_to_ndc.map(|matrix| matrix * back),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_sees_the_placed_scene_as_before() {
        let to_ndc = DMat4::from_cols_array_2d(&[
            [0.5, 0.0, 0.0, 0.0],
            [0.0, -0.5, 0.0, 0.0],
            [-0.5, -0.5, -1.0, -1.0],
            [0.0; 4],
        ]);
        let view =
            DMat4::from_rotation_y(0.3) * DMat4::from_translation(DVec3::new(1.0, 2.0, -5.0));
        let camera =
            ShadowCamera { world_to_camera: Some(view), world_to_ndc: Some(to_ndc * view) };
        let point = DVec3::new(0.2, -0.7, 0.1);
        let here = camera.project(point).unwrap().unwrap();
        for placement in Placement::elsewhere(2.0) {
            let there = placement.camera(&camera).project(placement.point(point));
            let there = there.unwrap().unwrap();
            assert!((there.truncate() - here.truncate()).length() < 1e-10, "{placement:?}");
            assert!((there.z / placement.scale() - here.z).abs() < 1e-10, "{placement:?}");
        }
    }
}
