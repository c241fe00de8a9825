//! Percentage closer filtering with the bias that filtered lookups have.

use std::convert::Infallible;
use std::sync::{Mutex, PoisonError};

use dsm_core::{AreaLight, BiasSummary, Facing, LightVisibility, ShadedPoint, ShadowLookup};
use glam::DVec3;

use super::pcf::PercentageCloserFilter;

/// A plain shadow map that is asked where a deep one would be: its filter with
/// the biases of a [`ShadowLookup`], which may follow each point's slope.
#[derive(Debug)]
pub struct PercentageCloserShadow {
    filter: PercentageCloserFilter,
    lookup: ShadowLookup,
    biases: Mutex<BiasSummary>,
}

impl PercentageCloserShadow {
    /// Asks `filter` where `lookup` says; its own bias does not count.
    #[must_use]
    pub fn new(filter: PercentageCloserFilter, lookup: ShadowLookup) -> Self {
        Self { filter, lookup, biases: Mutex::default() }
    }

    /// The biases of all points so far.
    #[must_use]
    pub fn biases(&self) -> BiasSummary {
        *self.biases.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl LightVisibility for PercentageCloserShadow {
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
