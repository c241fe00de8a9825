//! Transforms of objects while the shutter is open.

use glam::{DAffine3, DMat3, DVec3};

use crate::error::{Error, Place, Result};

/// A similarity: p' = translate + Rz · Ry · Rx · (scale · p).
///
/// ```
/// use dsm_scene::Transform;
/// use glam::DVec3;
///
/// let transform = Transform { translate: DVec3::Y, scale: 2.0, ..Transform::default() };
/// let point = transform.matrix().transform_point3(DVec3::X);
/// assert_eq!(point, DVec3::new(2.0, 1.0, 0.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    /// Added last, in scene units.
    pub translate: DVec3,
    /// Angles about the x, y and z axes in degrees, applied in this order.
    pub rotate: DVec3,
    /// Applied first, > 0.
    pub scale: f64,
}

impl Default for Transform {
    fn default() -> Self {
        Self { translate: DVec3::ZERO, rotate: DVec3::ZERO, scale: 1.0 }
    }
}

impl Transform {
    /// The numbers as they are, once they are finite and the scale > 0.
    ///
    /// # Errors
    ///
    /// [`Error::Malformed`] otherwise.
    pub fn check(self) -> Result<Self> {
        let refuse = |reason| Err(Error::malformed(Place::Named("transform".into()), reason));
        if !(self.translate.is_finite() && self.rotate.is_finite()) {
            return refuse("translate and rotate must be finite");
        }
        if !(1e-18..=1e18).contains(&self.scale) {
            return refuse("scale must lie between 1e-18 and 1e18");
        }
        Ok(self)
    }

    /// The matrix, of the same bits on every platform.
    #[must_use]
    pub fn matrix(&self) -> DAffine3 {
        let turn = |degrees: f64| libm::sincos((degrees % 360.0).to_radians());
        let columns = |x, y, z| DMat3::from_cols(DVec3::from(x), DVec3::from(y), DVec3::from(z));
        let (sin, cos) = turn(self.rotate.x);
        let about_x = columns([1.0, 0.0, 0.0], [0.0, cos, sin], [0.0, -sin, cos]);
        let (sin, cos) = turn(self.rotate.y);
        let about_y = columns([cos, 0.0, -sin], [0.0, 1.0, 0.0], [sin, 0.0, cos]);
        let (sin, cos) = turn(self.rotate.z);
        let about_z = columns([cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]);
        let rotation = about_z * about_y * about_x;
        DAffine3::from_mat3_translation(rotation * self.scale, self.translate)
    }

    /// The transform between this one (0) and `other` (1): every number goes
    /// linearly, so that angles turn evenly and points of a spinning object stay on
    /// their circles.
    #[must_use]
    pub fn lerp(&self, other: &Self, time: f64) -> Self {
        Self {
            translate: self.translate.lerp(other.translate, time),
            rotate: self.rotate.lerp(other.rotate, time),
            scale: self.scale + (other.scale - self.scale) * time,
        }
    }
}

/// A transform where the shutter opens, and one where it closes.
///
/// ```
/// use dsm_scene::{Motion, Transform};
/// use glam::DVec3;
///
/// let close = Transform { translate: DVec3::X, ..Transform::default() };
/// let motion = Motion { close, ..Motion::default() };
/// assert!(motion.is_moving());
/// assert_eq!(motion.at(0.5).translation, DVec3::X * 0.5);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// The transform when the shutter opens: time 0.
    pub open: Transform,
    /// The transform when the shutter closes: time 1.
    pub close: Transform,
}

impl Motion {
    /// An object that stands still.
    #[must_use]
    pub const fn still(transform: Transform) -> Self {
        Self { open: transform, close: transform }
    }

    /// True if the object moves at all.
    #[must_use]
    pub fn is_moving(&self) -> bool {
        self.open != self.close
    }

    /// Object to world at `time`, clamped to [0, 1].
    #[must_use]
    pub fn at(&self, time: f64) -> DAffine3 {
        if self.is_moving() {
            self.open.lerp(&self.close, time.clamp(0.0, 1.0)).matrix()
        } else {
            self.open.matrix()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_matrix_turns_about_x_then_y_then_z() {
        let transform = Transform {
            translate: DVec3::new(1.0, 2.0, 3.0),
            rotate: DVec3::new(20.0, -35.0, 140.0),
            scale: 2.5,
        };
        let expected = DAffine3::from_translation(transform.translate)
            * DAffine3::from_rotation_z(transform.rotate.z.to_radians())
            * DAffine3::from_rotation_y(transform.rotate.y.to_radians())
            * DAffine3::from_rotation_x(transform.rotate.x.to_radians())
            * DAffine3::from_scale(DVec3::splat(transform.scale));
        assert!(transform.matrix().abs_diff_eq(expected, 1e-14));
    }

    #[test]
    fn motion_turns_evenly() {
        let close = Transform { rotate: DVec3::new(0.0, 0.0, 180.0), ..Transform::default() };
        let motion = Motion { open: Transform::default(), close };
        let half = motion.at(0.5).transform_point3(DVec3::X);
        assert!((half - DVec3::Y).length() < 1e-15);
        assert_eq!(motion.at(-1.0), motion.at(0.0));
        assert!(!Motion::still(close).is_moving());
    }

    #[test]
    fn odd_transforms_are_refused() {
        let plain = Transform::default();
        for scale in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Transform { scale, ..plain }.check().is_err());
        }
        let translate = DVec3::new(0.0, f64::NAN, 0.0);
        assert!(Transform { translate, ..plain }.check().is_err());
        assert_eq!(plain.check().unwrap(), plain);
    }
}
