//! The middle of figure 10: what each acceleration of traced views is worth.

use std::time::Instant;

use dsm_core::{AreaLight, LightVisibility, ShadedPoint};
use shadow_maps::detail::{TraceOptions, ViewsTracer};

use super::trial::Difference;
use crate::figures::{seconds, table};

/// The paper's hierarchical tracing without accelerations.
const PLAIN: TraceOptions = TraceOptions { hierarchy: true, ..TraceOptions::NONE };

/// What is traced with what.
fn variants() -> Vec<(&'static str, TraceOptions)> {
    let all = TraceOptions::ALL;
    vec![
        ("from pixel to pixel", TraceOptions::NONE),
        ("hierarchy alone: the paper's base", PLAIN),
        ("and clipping", TraceOptions { clipping: true, ..PLAIN }),
        ("and connectedness", TraceOptions { connectedness: true, ..PLAIN }),
        ("and clear misses", TraceOptions { clear_miss: true, ..PLAIN }),
        ("and occlusion intervals", TraceOptions { intervals: true, ..PLAIN }),
        ("and ranking", TraceOptions { ranking: true, ..PLAIN }),
        ("all", all),
        ("all but hierarchy", TraceOptions { hierarchy: false, ..all }),
        ("all but clipping", TraceOptions { clipping: false, ..all }),
        ("all but connectedness", TraceOptions { connectedness: false, ..all }),
        ("all but clear misses", TraceOptions { clear_miss: false, ..all }),
        ("all but occlusion intervals", TraceOptions { intervals: false, ..all }),
        ("all but ranking", TraceOptions { ranking: false, ..all }),
    ]
}

/// What tracing gave and took.
pub(super) struct Traced {
    pub(super) difference: Difference,
    /// Million rays a second of this thread.
    pub(super) rate: f64,
    /// Of a ray: pixels and nodes that were looked at, and views.
    pub(super) steps: f64,
    pub(super) views: f64,
}

/// Traces `rays` rays of each point.
pub(super) fn trace(
    tracer: &ViewsTracer,
    points: &[ShadedPoint],
    light: &AreaLight,
    rays: u32,
    reference: &[f32],
) -> Traced {
    let tracer = tracer.clone().with_rays(rays);
    let started = Instant::now();
    let (before, mut found) = (seconds(started), Vec::with_capacity(points.len()));
    let Ok(()) = tracer.visibilities(points, light, &mut found);
    let spent = seconds(started) - before;
    // Counted by themselves, of fewer.
    let (mut steps, mut views, mut counted) = (0_u64, 0_u64, 0_u64);
    for point in points.iter().step_by(8) {
        for sample in light.samples(point.position, rays, point.seed) {
            let fate = tracer.trace(point.position, sample);
            steps += fate.steps;
            views += u64::from(fate.views);
            counted += 1;
        }
    }
    Traced {
        difference: Difference::new(&found, reference, 1),
        rate: points.len() as f64 * f64::from(rays) / spent / 1e6,
        steps: steps as f64 / counted as f64,
        views: views as f64 / counted as f64,
    }
}

/// The table of all variants.
pub(super) fn compare(
    tracer: &ViewsTracer,
    points: &[ShadedPoint],
    light: &AreaLight,
    rays: u32,
    reference: &[f32],
) -> String {
    let run =
        |options| trace(&tracer.clone().with_options(options), points, light, rays, reference);
    let found: Vec<_> =
        variants().into_iter().map(|(name, options)| (name, options, run(options))).collect();
    let base = found.iter().find(|(_, options, _)| *options == PLAIN);
    let base = base.map_or(f64::NAN, |(_, _, traced)| traced.rate);
    let rows = found.iter().map(|(name, _, traced)| {
        vec![
            (*name).to_owned(),
            format!("{:.3}", traced.rate),
            format!("{:.2}", traced.rate / base),
            format!("{:.1}", traced.steps),
            format!("{:.2}", traced.views),
            format!("{:.4}", traced.difference.rmse),
            format!("{:+.4}", traced.difference.mean),
        ]
    });
    table(
        &[
            "accelerations",
            "million rays/s",
            "speed-up",
            "steps a ray",
            "views a ray",
            "RMSE",
            "mean",
        ],
        rows,
    )
}
