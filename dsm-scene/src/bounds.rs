//! Axis-aligned boxes.

use glam::{DAffine3, DVec3, Vec3};

/// An axis-aligned box in `f64`; empty until something is added.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The lower corner.
    pub min: DVec3,
    /// The upper corner.
    pub max: DVec3,
}

impl Default for Bounds {
    fn default() -> Self {
        Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY }
    }
}

impl Bounds {
    /// The smallest box around points with a radius each.
    pub(crate) fn of_balls(balls: impl IntoIterator<Item = (Vec3, f32)>) -> Self {
        let mut bounds = Self::default();
        for (centre, radius) in balls {
            let (centre, radius) = (centre.as_dvec3(), DVec3::splat(f64::from(radius)));
            bounds.min = bounds.min.min(centre - radius);
            bounds.max = bounds.max.max(centre + radius);
        }
        bounds
    }

    /// The smallest box around both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// True if nothing was added.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        !(self.min.cmple(self.max).all())
    }

    /// The middle.
    #[must_use]
    pub fn centre(&self) -> DVec3 {
        (self.min + self.max) * 0.5
    }

    /// A box around the box, transformed.
    #[must_use]
    pub fn transformed(&self, matrix: &DAffine3) -> Self {
        if self.is_empty() {
            return *self;
        }
        let half = (self.max - self.min) * 0.5;
        let reach = matrix.matrix3.abs() * half;
        let centre = matrix.transform_point3(self.centre());
        Self { min: centre - reach, max: centre + reach }
    }

    /// The range of t where the line `origin` + t · `direction` is inside; `None`
    /// where nowhere.
    #[inline]
    pub(crate) fn clip(&self, origin: DVec3, direction: DVec3) -> Option<(f64, f64)> {
        let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
        for axis in 0..3 {
            if direction[axis] == 0.0 {
                if !(self.min[axis]..=self.max[axis]).contains(&origin[axis]) {
                    return None;
                }
                continue;
            }
            let a = (self.min[axis] - origin[axis]) / direction[axis];
            let b = (self.max[axis] - origin[axis]) / direction[axis];
            near = near.max(a.min(b));
            far = far.min(a.max(b));
        }
        (near <= far).then_some((near, far))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_clip_lines() {
        let bounds = Bounds { min: DVec3::ZERO, max: DVec3::ONE };
        let start = DVec3::new(0.5, 0.5, -1.0);
        assert_eq!(bounds.clip(start, DVec3::Z), Some((1.0, 2.0)));
        assert_eq!(bounds.clip(start, -DVec3::Z), Some((-2.0, -1.0)));
        assert_eq!(bounds.clip(start, DVec3::X), None);
        assert_eq!(bounds.clip(start + DVec3::X, DVec3::Z), None);
        assert!(Bounds::default().is_empty() && !bounds.is_empty());
    }

    #[test]
    fn a_transformed_box_holds_its_transformed_corners() {
        let bounds = Bounds { min: DVec3::new(-1.0, 0.0, 2.0), max: DVec3::new(1.0, 3.0, 2.5) };
        let matrix = DAffine3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.1);
        let image = bounds.transformed(&matrix);
        for corner in 0..8 {
            let pick = |axis: usize| if corner >> axis & 1 == 0 { bounds.min } else { bounds.max };
            let corner = DVec3::new(pick(0).x, pick(1).y, pick(2).z);
            let corner = matrix.transform_point3(corner);
            assert!(corner.cmpge(image.min - 1e-12).all() && corner.cmple(image.max + 1e-12).all());
        }
    }
}
