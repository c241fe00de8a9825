//! Maps of a scene in memory, and what asking them gives and takes.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use anyhow::Result;
use dsm_core::{AreaLight, HitSource, ShadedPoint, TileHits, TileSamples};
use dsm_scene::{Scene, SceneRasterizer};
use shadow_maps::detail::{AttenuationBuilder, AttenuationMap, AttenuationShadow};

use crate::figures::seconds;
use crate::soft_shadows::Shadow;

/// Points are asked again until so many seconds are over.
const LEAST_SECONDS: f64 = 0.1;

/// An attenuation map, and what it took.
pub(super) struct Attenuated {
    /// Its shadows, of one texel each.
    pub(super) shadow: AttenuationShadow<AttenuationMap<f32>>,
    /// Seconds of this thread: all, and rendering alone.
    pub(super) seconds: [f64; 2],
    /// Layers a texel that has any.
    pub(super) complexity: f64,
    /// Layers that are kept.
    pub(super) layers: usize,
}

impl Attenuated {
    /// Of `side` × `side` texels from `samples` points of the light, with a tolerance of depths
    /// in sides of a texel.
    pub(super) fn new(scene: &Scene, side: u32, samples: u32, tolerance: f64) -> Result<Self> {
        let started = Instant::now();
        let before = seconds(started);
        let view = scene.light.raster([side; 2])?;
        let light = scene.light.area()?;
        let mut builder =
            AttenuationBuilder::<f32>::with_tolerance(view.shadow_camera(), [side; 2], tolerance)?;
        let mut rendering = 0.0;
        for eye in light.samples(scene.light.view.target, samples, 0) {
            let view = view.at_eye(eye);
            let from = Instant::now();
            let source = Timed::new(SceneRasterizer::<f32>::new(scene, view)?);
            rendering += from.elapsed().as_secs_f64();
            // Nobody breaks it off.
            let _ =
                builder.add_view(&source, view.shadow_camera(), || ControlFlow::Continue(()))?;
            rendering += source.spent();
        }
        let (lists, _) = builder.finish()?;
        let all = seconds(started) - before;
        // Whatever else runs holds both up alike.
        let rendering = all * rendering / started.elapsed().as_secs_f64();
        let texels = (0..side).flat_map(|y| (0..side).map(move |x| (x, y)));
        let full = texels.filter(|&(x, y)| !lists.at(x.into(), y.into()).w.is_empty()).count();
        let layers = lists.len();
        let complexity = layers as f64 / full.max(1) as f64;
        let shadow = AttenuationShadow::new(AttenuationMap::new(*builder.frame(), lists)?);
        Ok(Self { shadow, seconds: [all, rendering], complexity, layers })
    }
}

/// A source of hits that tells how long it was asked.
struct Timed<S> {
    source: S,
    nanoseconds: AtomicU64,
}

impl<S> Timed<S> {
    const fn new(source: S) -> Self {
        Self { source, nanoseconds: AtomicU64::new(0) }
    }

    fn spent(&self) -> f64 {
        self.nanoseconds.load(Ordering::Relaxed) as f64 * 1e-9
    }
}

impl<S: HitSource<f32>> HitSource<f32> for Timed<S> {
    type Error = S::Error;

    fn hits(&self, samples: &TileSamples, hits: &mut TileHits<f32>) -> Result<(), S::Error> {
        let started = Instant::now();
        let found = self.source.hits(samples, hits);
        self.nanoseconds.fetch_add(started.elapsed().as_nanos() as u64, Ordering::Relaxed);
        found
    }
}

/// The difference from a reference.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Difference {
    /// Root of the mean square.
    pub(crate) rmse: f64,
    /// Mean: above 0 where it is too light.
    pub(crate) mean: f64,
}

impl Difference {
    /// Of `found` from `reference`, which has one of every so many.
    pub(crate) fn new(found: &[f32], reference: &[f32], every: usize) -> Self {
        let count = reference.len().max(1) as f64;
        let pairs = found.iter().step_by(every.max(1)).zip(reference);
        let off = pairs.map(|(&a, &b)| f64::from(a) - f64::from(b));
        let mean = off.clone().sum::<f64>() / count;
        Self { rmse: (off.map(|off| off * off).sum::<f64>() / count).sqrt(), mean }
    }
}

/// The shadow factors of points, and microseconds of this thread a point, asked again until
/// clocks have ticked.
pub(super) fn ask(
    shadow: &Shadow<'_>,
    points: &[ShadedPoint],
    light: &AreaLight,
) -> (Vec<f32>, f64) {
    let mut found = Vec::with_capacity(points.len());
    let mut best = f64::INFINITY;
    let started = Instant::now();
    let (before, mut rounds) = (seconds(started), 0);
    while rounds == 0 || seconds(started) - before < LEAST_SECONDS {
        found.clear();
        let round = seconds(started);
        let Ok(()) = shadow.visibilities(points, light, &mut found);
        best = best.min(seconds(started) - round);
        rounds += 1;
    }
    // Short rounds are less than a tick.
    let mean = (seconds(started) - before) / f64::from(rounds);
    let taken = if rounds > 3 { mean } else { best };
    (found, taken * 1e6 / points.len().max(1) as f64)
}
