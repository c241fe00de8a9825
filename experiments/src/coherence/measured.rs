//! Coherent sampling beside plain sampling of the same cells.

use std::convert::Infallible;
use std::time::Instant;

use dsm_core::{AreaLight, LightVisibility, OcclusionTracer, ShadedPoint};
use dsm_trace::detail::{CoherenceSettings, CoherenceStatistics, CoherentShadow};

use crate::attenuation::trial::Difference;
use crate::figures::seconds;

/// What coherent sampling gave and took.
pub(super) struct Measured {
    /// From plain sampling by the same rays.
    pub(super) difference: Difference,
    pub(super) counted: CoherenceStatistics,
    /// Seconds of this thread, plain and coherent.
    pub(super) seconds: [f64; 2],
}

impl Measured {
    /// Asks for groups of points that lie together, each by itself.
    pub(super) fn new<O>(
        tracer: &O,
        groups: &[Vec<ShadedPoint>],
        light: &AreaLight,
        settings: CoherenceSettings,
    ) -> Self
    where
        O: OcclusionTracer<Value = f32, Error = Infallible>,
    {
        let plain = CoherentShadow::new(tracer, settings.with_prediction(false));
        let coherent = CoherentShadow::new(tracer, settings);
        let (want, all) = ask(&plain, groups, light);
        let (found, some) = ask(&coherent, groups, light);
        Self {
            difference: Difference::new(&found, &want, 1),
            counted: coherent.statistics(),
            seconds: [all, some],
        }
    }

    /// Traced rays a point.
    pub(super) fn rays(&self) -> f64 {
        self.counted.rays as f64 / self.counted.receivers.max(1) as f64
    }

    /// The share of cells that were traced.
    pub(super) fn share(&self) -> f64 {
        self.counted.rays as f64 / self.counted.cells.max(1) as f64
    }

    /// How many times as fast as plain sampling it is.
    pub(super) fn speed_up(&self) -> f64 {
        self.seconds[0] / self.seconds[1]
    }

    /// The share of points of which every cell was traced.
    pub(super) fn fresh(&self) -> f64 {
        self.counted.fresh as f64 / self.counted.receivers.max(1) as f64
    }

    /// The columns of [`Self::cells`].
    pub(super) const COLUMNS: [&str; 7] =
        ["rays a point", "of all", "speed-up", "RMSE", "mean", "traced whole", "µs a point"];

    /// The numbers of a row.
    pub(super) fn cells(&self) -> Vec<String> {
        let micros = 1e6 * self.seconds[1] / self.counted.receivers.max(1) as f64;
        vec![
            format!("{:.1}", self.rays()),
            format!("{:.0} %", 100.0 * self.share()),
            format!("{:.2}", self.speed_up()),
            format!("{:.4}", self.difference.rmse),
            format!("{:+.4}", self.difference.mean),
            format!("{:.1} %", 100.0 * self.fresh()),
            format!("{micros:.1}"),
        ]
    }
}

/// The shadow factors of all groups, and the seconds that they took.
fn ask<O>(
    shadow: &CoherentShadow<&O>,
    groups: &[Vec<ShadedPoint>],
    light: &AreaLight,
) -> (Vec<f32>, f64)
where
    O: OcclusionTracer<Value = f32, Error = Infallible>,
{
    let (started, mut found) = (Instant::now(), Vec::new());
    let before = seconds(started);
    for group in groups {
        let Ok(()) = shadow.visibilities(group, light, &mut found);
    }
    (found, seconds(started) - before)
}
