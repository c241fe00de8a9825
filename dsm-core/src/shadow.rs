//! What every method of computing shadows answers.

use glam::DVec3;

use crate::{AreaLight, Transmittance};

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

/// Computes soft shadows: one receiver, one light.
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
}
