//! Lights with an area, and the points on them that shadow rays go to.

use glam::{DVec2, DVec3};

use crate::light_extent::{LightExtent, LightShape};
use crate::random::{next_bits, unit};

/// The share of a distance by which a point that lies on the light may be beyond it.
const ROUNDING: f64 = 1e-9;

/// An area light in the world: a centre and two half axes.
///
/// The shadow factor of a receiver is the mean transmittance to points spread
/// evenly over the light, without the cosine at the receiver.
///
/// ```
/// use dsm_core::AreaLight;
/// use glam::DVec3;
///
/// let light = AreaLight::rectangle(DVec3::Y * 5.0, DVec3::X, DVec3::Z * 0.5);
/// let points: Vec<_> = light.samples(DVec3::ZERO, 16, 7).collect();
/// assert_eq!(points.len(), 16);
/// assert!(points.iter().all(|p| p.y == 5.0 && p.x.abs() <= 1.0 && p.z.abs() <= 0.5));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaLight {
    shape: LightShape,
    centre: DVec3,
    right: DVec3,
    up: DVec3,
}

impl AreaLight {
    /// A light without extent.
    #[must_use]
    pub const fn point(centre: DVec3) -> Self {
        Self { shape: LightShape::Point, centre, right: DVec3::ZERO, up: DVec3::ZERO }
    }

    /// A rectangle that reaches from `centre` by `right` and by `up` to either
    /// side.
    #[must_use]
    pub const fn rectangle(centre: DVec3, right: DVec3, up: DVec3) -> Self {
        Self { shape: LightShape::Rectangle, centre, right, up }
    }

    /// A disk, or an ellipse, with these half axes.
    #[must_use]
    pub const fn disk(centre: DVec3, right: DVec3, up: DVec3) -> Self {
        Self { shape: LightShape::Disk, centre, right, up }
    }

    /// A sphere. A receiver sees it as the disk of its great circle.
    #[must_use]
    pub fn sphere(centre: DVec3, radius: f64) -> Self {
        let (right, up) = (DVec3::X * radius, DVec3::Y * radius);
        Self { shape: LightShape::Sphere, centre, right, up }
    }

    /// The shape.
    #[must_use]
    pub const fn shape(&self) -> LightShape {
        self.shape
    }

    /// The centre, in the world.
    #[must_use]
    pub const fn centre(&self) -> DVec3 {
        self.centre
    }

    /// The vectors from the centre to the right edge and to the upper one.
    #[must_use]
    pub const fn half_axes(&self) -> [DVec3; 2] {
        [self.right, self.up]
    }

    /// Its shape and size, rounded to `f32`, as a map's header keeps them.
    #[must_use]
    pub fn extent(&self) -> LightExtent {
        let size = [self.right, self.up].map(|axis| f64::from((2.0 * axis.length()) as f32));
        LightExtent::of_shape(self.shape, size)
    }

    /// The point of the light at (`u`, `v`) in [0, 1]², as `receiver` sees it:
    /// even in `u`, `v` gives even over the light's area.
    #[must_use]
    pub fn at(&self, receiver: DVec3, u: f64, v: f64) -> DVec3 {
        let square = DVec2::new(2.0 * u - 1.0, 2.0 * v - 1.0);
        let Some([right, up]) = self.axes_towards(receiver) else { return self.centre };
        let on = if self.is_round() { concentric_disk(square) } else { square };
        self.centre + right * on.x + up * on.y
    }

    /// The (`u`, `v`) in [0, 1)² of the light's point that `receiver` sees behind
    /// `point`, the inverse of [`Self::at`]; `None` where it sees none there, and for
    /// lights without an area.
    ///
    /// ```
    /// use dsm_core::AreaLight;
    /// use glam::DVec3;
    ///
    /// let light = AreaLight::rectangle(DVec3::Y * 4.0, DVec3::X, DVec3::Z);
    /// assert_eq!(light.behind(DVec3::ZERO, DVec3::new(0.25, 2.0, 0.0)), Some([0.75, 0.5]));
    /// assert_eq!(light.behind(DVec3::ZERO, DVec3::new(1.0, 2.0, 0.0)), None);
    /// ```
    #[must_use]
    pub fn behind(&self, receiver: DVec3, point: DVec3) -> Option<[f64; 2]> {
        let [right, up] = self.axes_towards(receiver)?;
        let normal = right.cross(up);
        let towards = point - receiver;
        // How many times as far as the point the light is.
        let times = normal.dot(self.centre - receiver) / normal.dot(towards);
        if !(times.is_finite() && times >= 1.0 - ROUNDING) {
            return None;
        }
        let on = receiver + towards * times - self.centre;
        let area = normal.length_squared();
        let on = DVec2::new(on.cross(up).dot(normal), right.cross(on).dot(normal)) / area;
        let square = if self.is_round() { square_of_disk(on) } else { on };
        let place = [square.x, square.y].map(|at| 0.5 * (at + 1.0));
        place.iter().all(|at| (0.0..1.0).contains(at)).then_some(place)
    }

    const fn is_round(&self) -> bool {
        matches!(self.shape, LightShape::Disk | LightShape::Sphere)
    }

    /// The half axes of the outline that `receiver` sees; none of a point.
    fn axes_towards(&self, receiver: DVec3) -> Option<[DVec3; 2]> {
        match self.shape {
            LightShape::Point => None,
            LightShape::Rectangle | LightShape::Disk => Some([self.right, self.up]),
            LightShape::Sphere => {
                let towards = (receiver - self.centre).try_normalize()?;
                let (right, up) = towards.any_orthonormal_pair();
                let radius = self.right.length();
                Some([right * radius, up * radius])
            }
        }
    }

    /// `count` points spread over the light: a Hammersley set, shifted by an
    /// amount that depends on `seed` alone and jittered within its strata, so
    /// that receivers with different seeds have independent errors. The same
    /// arguments give the same points.
    pub fn samples(
        &self,
        receiver: DVec3,
        count: u32,
        seed: u64,
    ) -> impl ExactSizeIterator<Item = DVec3> + use<> {
        let light = *self;
        let mut state = seed;
        let turn = next_bits(&mut state) as u32;
        let strata = f64::from(count.max(1));
        (0..count).map(move |index| {
            let jitter = unit(next_bits(&mut state));
            let scatter = unit(next_bits(&mut state));
            let u = (f64::from(index) + jitter) / strata;
            let turned = index.reverse_bits() ^ turn;
            let v = (f64::from(turned) + scatter) / 2.0_f64.powi(32);
            // The last bits of v are far finer than a stratum: jitter there too.
            let v = v + (scatter - 0.5) / strata;
            light.at(receiver, u, v - v.floor())
        })
    }
}

/// Shirley and Chiu's map from the square [−1, 1]² to the unit disk: keeps
/// areas and neighbourhoods.
fn concentric_disk(square: DVec2) -> DVec2 {
    if square == DVec2::ZERO {
        return DVec2::ZERO;
    }
    let quarter = std::f64::consts::FRAC_PI_4;
    let (radius, angle) = if square.x.abs() > square.y.abs() {
        (square.x, quarter * square.y / square.x)
    } else {
        (square.y, 2.0 * quarter - quarter * square.x / square.y)
    };
    DVec2::from_angle(angle) * radius
}

/// The inverse of [`concentric_disk`].
fn square_of_disk(disk: DVec2) -> DVec2 {
    let (eighth, radius) = (std::f64::consts::FRAC_PI_4, disk.length());
    let along = |angle: f64| angle / eighth * radius;
    if disk.x.abs() > disk.y.abs() {
        let angle = (disk.y / disk.x).atan();
        DVec2::new(radius, along(angle)) * disk.x.signum()
    } else if disk.y == 0.0 {
        DVec2::ZERO
    } else {
        let angle = (disk.x / disk.y).atan();
        DVec2::new(along(angle), radius) * disk.y.signum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The number of `points` in each cell of a `cells` × `cells` grid
    /// over [−1, 1]² of x and z.
    fn histogram(points: impl Iterator<Item = DVec3>, cells: usize) -> Vec<u32> {
        let mut counts = vec![0; cells * cells];
        let cell = |value: f64| (((value + 1.0) / 2.0 * cells as f64) as usize).min(cells - 1);
        points.for_each(|p| counts[cell(p.z) * cells + cell(p.x)] += 1);
        counts
    }

    #[test]
    fn samples_spread_evenly_over_a_rectangle() {
        let light = AreaLight::rectangle(DVec3::Y, DVec3::X, DVec3::Z);
        for seed in [0, 1, 99] {
            let counts = histogram(light.samples(DVec3::ZERO, 4096, seed), 8);
            assert!(counts.iter().all(|&count| (48..=80).contains(&count)), "{counts:?}");
        }
        let other: Vec<_> = light.samples(DVec3::ZERO, 4, 1).collect();
        assert_ne!(light.samples(DVec3::ZERO, 4, 0).collect::<Vec<_>>(), other);
        assert_eq!(light.samples(DVec3::ZERO, 4, 1).collect::<Vec<_>>(), other);
    }

    #[test]
    fn disks_and_spheres_keep_areas() {
        let disk = AreaLight::disk(DVec3::Y, DVec3::X, DVec3::Z);
        let sphere = AreaLight::sphere(DVec3::Y, 1.0);
        for light in [disk, sphere] {
            let points: Vec<_> = light.samples(DVec3::ZERO, 10_000, 3).collect();
            assert!(points.iter().all(|p| (*p - DVec3::Y).length() <= 1.0 + 1e-12));
            assert!(points.iter().all(|p| (p.y - 1.0).abs() < 1e-12));
            // Half the area lies within 1/√2 of the centre.
            let inner = points.iter().filter(|p| (**p - DVec3::Y).length_squared() < 0.5).count();
            assert!((4900..5100).contains(&inner), "{inner}");
            let right = points.iter().filter(|p| p.x > 0.0).count();
            assert!((4900..5100).contains(&right), "{right}");
        }
    }

    #[test]
    fn what_lies_before_a_place_of_the_light_leads_back_to_it() {
        let tilted = [DVec3::new(1.0, 0.3, -0.2), DVec3::new(0.1, 0.2, 0.7)];
        let centre = DVec3::new(3.0, 5.0, -2.0);
        let lights = [
            AreaLight::rectangle(centre, tilted[0], tilted[1]),
            AreaLight::disk(centre, tilted[0], tilted[1]),
            AreaLight::sphere(centre, 1.5),
        ];
        let mut state = 5;
        let mut next = || unit(next_bits(&mut state));
        for round in 0..3000 {
            let light = lights[round % 3];
            let receiver = DVec3::new(next(), next(), next()) * 20.0 - 10.0;
            let place = [next(), next()];
            let on = light.at(receiver, place[0], place[1]);
            let blocker = receiver.lerp(on, 0.05 + 0.9 * next());
            let Some(found) = light.behind(receiver, blocker) else {
                // Of the receivers some lie nearly in the light's plane.
                let edge = [place[0], place[1]].iter().any(|at| (at - 0.5).abs() > 0.499);
                assert!(edge, "{light:?} {receiver} {place:?}");
                continue;
            };
            let off = [0, 1].map(|axis| (found[axis] - place[axis]).abs());
            assert!(off[0].max(off[1]) < 1e-6, "{light:?} {receiver} {place:?} {found:?}");
            // Beyond the light, behind the receiver, beside it.
            assert_eq!(light.behind(receiver, receiver.lerp(on, 1.01)), None);
            assert_eq!(light.behind(receiver, receiver.lerp(on, -0.5)), None);
            let beside = on + (on - centre).normalize_or(DVec3::X) * 5.0;
            assert_eq!(light.behind(receiver, receiver.lerp(beside, 0.5)), None);
        }
        let receiver = DVec3::ZERO;
        for light in [AreaLight::point(centre), AreaLight::sphere(receiver, 1.0)] {
            assert_eq!(light.behind(receiver, DVec3::Y), None);
        }
        assert_eq!(lights[0].behind(receiver, DVec3::NAN), None);
    }

    #[test]
    fn degenerate_lights_are_points() {
        let centre = DVec3::new(1.0, 2.0, 3.0);
        let mut points = AreaLight::point(centre).samples(DVec3::ZERO, 3, 0);
        assert!(points.all(|point| point == centre));
        let sphere = AreaLight::sphere(centre, 1.0);
        assert_eq!(sphere.at(centre, 0.3, 0.9), centre);
        assert_eq!(AreaLight::point(centre).samples(centre, 0, 0).len(), 0);
    }
}
