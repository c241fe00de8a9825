//! The interface of shadow methods: visibility at shaded points.

use glam::DVec3;

use crate::light::AreaLight;
use crate::transmittance::Transmittance;

/// A method that traces single shadow rays: through a scene, or a map that stands
/// for one.
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
    /// What [`Self::Error`] says.
    fn transmittance(
        &self,
        receiver: DVec3,
        light: DVec3,
        time: f64,
    ) -> Result<Self::Value, Self::Error>;
}

/// The orientation of what a point lies on, which tells how its depth changes
/// nearby, as the light sees it.
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
    /// What [`Self::Error`] says.
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
