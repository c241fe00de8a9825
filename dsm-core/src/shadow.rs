//! The interface of shadow methods: visibility at shaded points.

use glam::DVec3;

use crate::light::AreaLight;
use crate::occlusion::Occlusion;
use crate::transmittance::Transmittance;

/// A method that traces single shadow rays: through a scene, or a map that stands
/// for one.
///
/// ```
/// use std::convert::Infallible;
///
/// use dsm_core::OcclusionTracer;
/// use glam::DVec3;
///
/// /// A plane at a height that lets a fraction of the light through.
/// struct Plane(f64, f32);
///
/// impl OcclusionTracer for Plane {
///     type Value = f32;
///     type Error = Infallible;
///
///     fn transmittance(&self, from: DVec3, to: DVec3, _time: f64) -> Result<f32, Infallible> {
///         let between = from.y < self.0 && to.y > self.0;
///         Ok(if between { self.1 } else { 1.0 })
///     }
/// }
///
/// let plane = Plane(1.0, 0.25);
/// assert_eq!(plane.transmittance(DVec3::ZERO, DVec3::Y * 2.0, 0.0), Ok(0.25));
/// assert_eq!(plane.transmittance(DVec3::Y * 1.5, DVec3::Y * 2.0, 0.0), Ok(1.0));
/// ```
pub trait OcclusionTracer: Sync {
    /// The transmittance of a ray, of one channel or three.
    type Value: Transmittance;
    /// The error of a query; `Infallible` in memory.
    type Error;

    /// The transmittance between `receiver` and `light`, two points of the world,
    /// at `time`: 0 is where the shutter opens, 1 where it closes.
    ///
    /// # Errors
    ///
    /// [`Self::Error`], as the method defines it.
    fn transmittance(
        &self,
        receiver: DVec3,
        light: DVec3,
        time: f64,
    ) -> Result<Self::Value, Self::Error>;

    /// Appends what the rays from `receiver` to each of `targets` meet to `found`, in
    /// order. Each target is a point of the light and the time of its ray.
    ///
    /// A tracer overrides this if it can tell where rays are blocked, which rays of
    /// neighbours are predicted from, or if it takes what the receiver lies on into
    /// account, or if many rays of one point cost less together.
    ///
    /// # Errors
    ///
    /// The first error; `found` then holds what came before.
    fn occlusions(
        &self,
        receiver: &ShadedPoint,
        targets: &[(DVec3, f64)],
        found: &mut Vec<Occlusion<Self::Value>>,
    ) -> Result<(), Self::Error> {
        for &(light, time) in targets {
            let transmittance = self.transmittance(receiver.position, light, time)?;
            found.push(Occlusion { transmittance, blocker: None });
        }
        Ok(())
    }
}

impl<O: OcclusionTracer + ?Sized> OcclusionTracer for &O {
    type Value = O::Value;
    type Error = O::Error;

    fn transmittance(
        &self,
        receiver: DVec3,
        light: DVec3,
        time: f64,
    ) -> Result<O::Value, O::Error> {
        (**self).transmittance(receiver, light, time)
    }

    fn occlusions(
        &self,
        receiver: &ShadedPoint,
        targets: &[(DVec3, f64)],
        found: &mut Vec<Occlusion<O::Value>>,
    ) -> Result<(), O::Error> {
        (**self).occlusions(receiver, targets, found)
    }
}

/// The orientation of what a point lies on, which tells how its depth changes
/// nearby, as the light sees it.
///
/// ```
/// use dsm_core::{Facing, ShadedPoint};
/// use glam::DVec3;
///
/// let position = DVec3::new(0.0, 1.0, 0.0);
/// let floor = ShadedPoint { position, facing: Facing::Surface(DVec3::Y), seed: 0 };
/// let hair = ShadedPoint { facing: Facing::Strand(DVec3::X), ..floor };
/// assert_ne!(floor.facing, hair.facing);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Facing {
    /// Nothing that has a direction, or an unknown one: the point faces the
    /// light.
    Light,
    /// A surface, by its unit normal on the side that is shaded.
    Surface(DVec3),
    /// A strand, by the unit vector along it.
    Strand(DVec3),
}

/// A receiver of shadow in the world.
///
/// ```
/// use dsm_core::{Facing, ShadedPoint};
/// use glam::DVec3;
///
/// // A point of smoke: it has no surface, and takes light from all sides.
/// let point = ShadedPoint { position: DVec3::ZERO, facing: Facing::Light, seed: 7 };
/// assert_eq!(point.facing, Facing::Light);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadedPoint {
    /// Position in the world.
    pub position: DVec3,
    /// Orientation of the surface or strand it lies on.
    pub facing: Facing,
    /// Seed that tells points apart where a method samples.
    pub seed: u64,
}

/// A shadow method: the visibility of one light at many receivers.
///
/// ```
/// use std::convert::Infallible;
///
/// use dsm_core::{AreaLight, LightVisibility};
/// use glam::DVec3;
///
/// /// A wall at x = 0, higher than any light.
/// struct Wall;
///
/// impl LightVisibility for Wall {
///     type Value = f32;
///     type Error = Infallible;
///
///     fn visibility(&self, at: DVec3, light: &AreaLight, seed: u64) -> Result<f32, Infallible> {
///         let samples: Vec<DVec3> = light.samples(at, 16, seed).collect();
///         let seen = samples.iter().filter(|sample| sample.x * at.x > 0.0).count();
///         Ok(seen as f32 / samples.len() as f32)
///     }
/// }
///
/// let light = AreaLight::rectangle(DVec3::Y * 5.0, DVec3::X, DVec3::Z);
/// assert_eq!(Wall.visibility(DVec3::X, &light, 0), Ok(0.5));
/// let beyond = AreaLight::point(DVec3::new(-1.0, 5.0, 0.0));
/// assert_eq!(Wall.visibility(DVec3::X, &beyond, 0), Ok(0.0));
/// ```
pub trait LightVisibility: Sync {
    /// The visibility of a receiver, of one channel or three.
    type Value: Transmittance;
    /// The error of a query; `Infallible` in memory.
    type Error;

    /// The shadow factor: the visibility at `receiver`, a point of the world,
    /// averaged over `light`'s area. `seed` tells receivers apart where the method
    /// samples.
    ///
    /// # Errors
    ///
    /// [`Self::Error`], as the method defines it.
    fn visibility(
        &self,
        receiver: DVec3,
        light: &AreaLight,
        seed: u64,
    ) -> Result<Self::Value, Self::Error>;

    /// Appends the shadow factor of every point of `points` to `values`, in order.
    /// A method overrides this if it can do more for many points than query
    /// [`Self::visibility`] for each, or if it needs to know what they lie on.
    ///
    /// # Errors
    ///
    /// The first error; `values` then holds what came before.
    fn visibilities(
        &self,
        points: &[ShadedPoint],
        light: &AreaLight,
        values: &mut Vec<Self::Value>,
    ) -> Result<(), Self::Error> {
        for point in points {
            values.push(self.visibility(point.position, light, point.seed)?);
        }
        Ok(())
    }
}
