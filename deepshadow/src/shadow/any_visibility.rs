//! Shadow methods without their types.

use dsm_core::{AreaLight, LightVisibility, ShadedPoint};

use super::statistics::ShadowStatistics;
use crate::error::{Error, Result};
use crate::values::Values;

/// A shadow method of some kind of map and number of channels. Calls take many
/// points, so that their cost does not count.
pub(crate) trait AnyVisibility: Send + Sync {
    /// Numbers a point: 1 or 3.
    fn channels(&self) -> usize;

    /// Appends the shadow factors of points of the world.
    fn world(&self, points: &[ShadedPoint], light: &AreaLight, values: &mut Values) -> Result<()>;

    /// Appends the shadow factors of points given by raster position, in pixels
    /// of level 0, and depth. The first has this seed, each other the next.
    fn raster(
        &self,
        points: &[[f64; 3]],
        seed: u64,
        light: &AreaLight,
        values: &mut Values,
    ) -> Result<()>;

    /// What was done so far.
    fn statistics(&self) -> ShadowStatistics {
        ShadowStatistics::default()
    }
}

/// A method that somebody else implements: points of the world alone.
pub(crate) struct Foreign<V>(pub(crate) V);

impl<V> AnyVisibility for Foreign<V>
where
    V: LightVisibility + Send + Sync,
    V::Error: std::error::Error + Send + Sync + 'static,
{
    fn channels(&self) -> usize {
        <V::Value as dsm_core::Transmittance>::CHANNELS
    }

    fn world(&self, points: &[ShadedPoint], light: &AreaLight, values: &mut Values) -> Result<()> {
        let mut own = Vec::with_capacity(points.len());
        let done = self.0.visibilities(points, light, &mut own);
        values.extend(&own);
        done.map_err(|error| Error::Occluders(Box::new(error)))
    }

    fn raster(&self, _: &[[f64; 3]], _: u64, _: &AreaLight, _: &mut Values) -> Result<()> {
        Err(Error::Unsupported("shadows without a map have no raster".to_owned()))
    }
}
