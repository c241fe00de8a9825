//! Percentage closer filtering with the bias that filtered lookups have.

use std::convert::Infallible;
use std::sync::{Mutex, PoisonError};

use dsm_core::{AreaLight, BiasSummary, Facing, LightVisibility, ShadedPoint, ShadowLookup};
use glam::DVec3;
use mtsm::PercentageCloserFilter;

/// A plain shadow map that is asked where a deep one would be, with the same
/// bias.
pub(crate) struct PcfShadow<'a> {
    filter: PercentageCloserFilter<'a>,
    lookup: ShadowLookup,
    biases: Mutex<BiasSummary>,
}

impl<'a> PcfShadow<'a> {
    pub(crate) fn new(filter: PercentageCloserFilter<'a>, lookup: ShadowLookup) -> Self {
        Self { filter, lookup, biases: Mutex::default() }
    }

    /// The biases of all points so far.
    pub(crate) fn biases(&self) -> BiasSummary {
        *self.biases.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl LightVisibility for PcfShadow<'_> {
    type Value = f32;
    type Error = Infallible;

    fn visibility(&self, receiver: DVec3, light: &AreaLight, seed: u64) -> Result<f32, Infallible> {
        let point = ShadedPoint { position: receiver, facing: Facing::Light, seed };
        let mut values = Vec::with_capacity(1);
        self.visibilities(&[point], light, &mut values)?;
        Ok(values.pop().unwrap_or(1.0))
    }

    fn visibilities(
        &self,
        points: &[ShadedPoint],
        _: &AreaLight,
        values: &mut Vec<f32>,
    ) -> Result<(), Infallible> {
        let mut biases = BiasSummary::default();
        values.extend(points.iter().map(|point| match self.lookup.receiver(point, 1) {
            Some(receiver) => {
                biases.add(receiver.bias);
                self.filter.lookup(&receiver, point.seed)
            }
            None => 1.0,
        }));
        self.biases.lock().unwrap_or_else(PoisonError::into_inner).merge(biases);
        Ok(())
    }
}
