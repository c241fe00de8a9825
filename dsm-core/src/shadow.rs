//! What every method of computing shadows answers.

use glam::DVec3;

use crate::light::AreaLight;
use crate::transmittance::Transmittance;

/// Traces single rays: a scene, or a map that stands for one.
pub trait OcclusionTracer: Sync {
    /// The fraction of light that is left, for one channel or three.
    type Value: Transmittance;
    /// What can go wrong on the way; `Infallible` in memory.
    type Error;

    /// The fraction of light that gets from `light` to `receiver`, two points
    /// of the world, at `time`: 0 is where the shutter opens, 1 where it
    /// closes.
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

/// What a point lies on, which tells how its depth changes nearby, as the light
/// sees it.
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

/// A point of the world that light falls on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadedPoint {
    /// Where it is.
    pub position: DVec3,
    /// What it lies on.
    pub facing: Facing,
    /// Tells points apart where a method samples.
    pub seed: u64,
}

/// Computes shadows: many receivers, one light.
pub trait LightVisibility: Sync {
    /// The fraction of light that is left, for one channel or three.
    type Value: Transmittance;
    /// What can go wrong on the way; `Infallible` in memory.
    type Error;

    /// The mean fraction of `light`'s area that `receiver`, a point of the
    /// world, sees: its shadow factor. `seed` tells receivers apart where the
    /// method samples.
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

    /// Appends the shadow factor of every point of `points` to `values`, in
    /// order. A method overrides this if it can do more for many points than
    /// ask [`Self::visibility`] for each, or if it needs to know what they lie
    /// on.
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
