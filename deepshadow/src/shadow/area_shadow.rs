//! Shadows of area lights, by rays, taps or lookups in a map.

use std::convert::Infallible;

use dsm_core::{AreaLight, Facing, LightVisibility, OcclusionTracer, ShadedPoint, Transmittance};
use dsm_trace::detail::{CoherenceStatistics, CoherentShadow, LightFrame, TraceStatistics};
use glam::DVec3;
use mtsm::detail::{MultilayerTracer, SoftPercentageCloser, TracedMap};
use shadow_maps::detail::{
    AttenuationShadow, CachedAttenuation, CachedPrefiltered, FragmentTracer, HybridShadow,
    PrefilteredShadow, ViewsTracer,
};

use super::any_visibility::AnyVisibility;
use super::statistics::ShadowStatistics;
use crate::error::{Error, Result};
use crate::values::Values;

/// A tracer or filter of a map with a light's frame.
pub(crate) trait AreaTracer: LightVisibility + Send + Sync {
    /// The frame of the map's light.
    fn frame(&self) -> &LightFrame;

    /// Rays or taps so far, of methods that have any.
    fn rays(&self) -> Option<TraceStatistics>;

    /// Whether a table of optical depths is used, where one may be.
    fn far_table(&self) -> Option<bool> {
        None
    }

    /// The cells that were traced, of a method that leaves some out.
    fn coherence(&self) -> Option<CoherenceStatistics> {
        None
    }
}

impl<M: TracedMap> AreaTracer for MultilayerTracer<M> {
    fn frame(&self) -> &LightFrame {
        self.frame()
    }

    fn rays(&self) -> Option<TraceStatistics> {
        Some(self.statistics())
    }
}

impl<M: TracedMap> AreaTracer for SoftPercentageCloser<M> {
    fn frame(&self) -> &LightFrame {
        self.frame()
    }

    fn rays(&self) -> Option<TraceStatistics> {
        Some(self.statistics())
    }
}

impl<T: Transmittance> AreaTracer for FragmentTracer<T> {
    fn frame(&self) -> &LightFrame {
        self.frame()
    }

    fn rays(&self) -> Option<TraceStatistics> {
        Some(self.statistics())
    }

    fn far_table(&self) -> Option<bool> {
        Some(self.has_far_table())
    }
}

impl<T: Transmittance> AreaTracer for PrefilteredShadow<CachedPrefiltered<T>> {
    fn frame(&self) -> &LightFrame {
        self.frame()
    }

    fn rays(&self) -> Option<TraceStatistics> {
        None
    }
}

impl<T, N> AreaTracer for HybridShadow<CachedPrefiltered<T>, N>
where
    T: Transmittance,
    N: OcclusionTracer<Value = T, Error = Infallible> + Send,
{
    fn frame(&self) -> &LightFrame {
        self.frame()
    }

    fn rays(&self) -> Option<TraceStatistics> {
        None
    }
}

impl<T: Transmittance> AreaTracer for AttenuationShadow<CachedAttenuation<T>> {
    fn frame(&self) -> &LightFrame {
        self.frame()
    }

    fn rays(&self) -> Option<TraceStatistics> {
        None
    }
}

impl AreaTracer for ViewsTracer {
    fn frame(&self) -> &LightFrame {
        self.frame()
    }

    fn rays(&self) -> Option<TraceStatistics> {
        None
    }
}

/// A tracer that is asked for part of its rays.
impl<O> AreaTracer for CoherentShadow<O>
where
    O: AreaTracer + OcclusionTracer<Value: Transmittance> + Send + Sync,
{
    fn frame(&self) -> &LightFrame {
        self.tracer().frame()
    }

    fn rays(&self) -> Option<TraceStatistics> {
        let rays = self.statistics().rays;
        let own = self.tracer().rays();
        Some(own.unwrap_or(TraceStatistics { rays, ..TraceStatistics::default() }))
    }

    fn coherence(&self) -> Option<CoherenceStatistics> {
        Some(self.statistics())
    }
}

/// The shadows of an area light that a tracer finds.
pub(crate) struct AreaShadow<V>(pub(crate) V);

impl<V: AreaTracer> AnyVisibility for AreaShadow<V>
where
    Error: From<V::Error>,
{
    fn channels(&self) -> usize {
        <V::Value as Transmittance>::CHANNELS
    }

    fn world(&self, points: &[ShadedPoint], light: &AreaLight, values: &mut Values) -> Result<()> {
        let mut own = Vec::with_capacity(points.len());
        let done = self.0.visibilities(points, light, &mut own);
        values.extend(&own);
        Ok(done?)
    }

    fn raster(
        &self,
        points: &[[f64; 3]],
        seed: u64,
        light: &AreaLight,
        values: &mut Values,
    ) -> Result<()> {
        let shaded = |(number, &[x, y, depth]): (u64, &[f64; 3])| {
            let position: DVec3 = self.0.frame().unproject(x, y, depth);
            ShadedPoint { position, facing: Facing::Light, seed: seed.wrapping_add(number) }
        };
        let points: Vec<_> = (0..).zip(points).map(shaded).collect();
        self.world(&points, light, values)
    }

    fn statistics(&self) -> ShadowStatistics {
        ShadowStatistics {
            rays: self.0.rays(),
            far_table: self.0.far_table(),
            coherence: self.0.coherence(),
            ..ShadowStatistics::default()
        }
    }
}
