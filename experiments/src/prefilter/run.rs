//! One map of a scene, and its lookups.

use std::time::Instant;

use anyhow::{Context, Result};
use dsm_core::{AreaLight, LightVisibility, Progress, ShadedPoint};
use dsm_scene::SceneRasterizer;
use dsm_scene::detail::SceneReference;
use shadow_maps::detail::{
    Accumulate, HybridShadow, ListBuilder, PrefilterSettings, PrefilteredMap, PrefilteredShadow,
    square_width,
};

use super::peer::PeerScene;

/// What a map is made by and asked with.
#[derive(Clone, Debug)]
pub struct Setup {
    /// Texels along a side of level 0.
    pub resolution: u32,
    /// The maximum number of fragments a texel.
    pub layers: Option<u32>,
    /// How levels are made.
    pub filtering: PrefilterSettings,
    /// How lookups accumulate.
    pub accumulate: Accumulate,
    /// The depth bias in scene units.
    pub bias: Option<f64>,
    /// Parts of the light along a side.
    pub splits: u32,
    /// Whether points have the normals of their surfaces.
    pub normals: bool,
    /// Short rays of a point, and how many texels wide their cone ends.
    pub hybrid: Option<(u32, f64)>,
}

impl Default for Setup {
    fn default() -> Self {
        Self {
            resolution: 1024,
            layers: None,
            filtering: PrefilterSettings::default(),
            accumulate: Accumulate::Multiply,
            bias: None,
            splits: 1,
            normals: false,
            hybrid: None,
        }
    }
}

/// The difference from the reference.
#[derive(Clone, Copy, Debug, Default)]
pub struct Difference {
    /// Root of the mean square.
    pub rmse: f64,
    /// Mean: above 0 where it is too light.
    pub mean: f64,
}

impl Difference {
    fn new(found: &[f32], reference: &[f64]) -> Self {
        let count = found.len().max(1) as f64;
        let off = found.iter().zip(reference).map(|(&a, b)| f64::from(a) - b);
        let mean = off.clone().sum::<f64>() / count;
        Self { rmse: (off.map(|off| off * off).sum::<f64>() / count).sqrt(), mean }
    }
}

/// What a map gave.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Of points on the ground, on the object, and all.
    pub differences: [Difference; 3],
    /// Microseconds a point on the ground, and on the object.
    pub micros: [f64; 2],
    /// Seconds of collecting hits, sorting them, filtering levels.
    pub seconds: [f64; 3],
    /// Fragments of each level.
    pub fragments: Vec<usize>,
}

/// Builds the map of a scene on the current pool.
///
/// # Errors
///
/// What the scene or the settings are not.
pub fn build(peer: &PeerScene, setup: &Setup) -> Result<(PrefilteredMap<f32>, [f64; 3])> {
    let view = peer.scene.light.raster([setup.resolution; 2])?;
    let mut builder = ListBuilder::new(view.shadow_camera(), view.resolution(), 0.0)?;
    if let Some(layers) = setup.layers {
        builder = builder.with_layers(layers)?;
    }
    let started = Instant::now();
    let source = SceneRasterizer::<f32>::new(&peer.scene, view)?;
    let collected = builder.collect::<f32, _>(&source, Progress::ignore)?;
    let collected = collected.context("broken off")?;
    let collect = started.elapsed().as_secs_f64();
    let (lists, _) = builder.sort(collected)?;
    let sort = started.elapsed().as_secs_f64() - collect;
    let light = square_width(peer.scene.light.extent);
    let map = PrefilteredMap::new(*builder.frame(), lists, &setup.filtering, light)?;
    let filter = started.elapsed().as_secs_f64() - collect - sort;
    Ok((map, [collect, sort, filter]))
}

/// Builds a map, and asks it for all points on the calling thread, some times: the
/// fastest counts.
///
/// # Errors
///
/// As [`build`].
pub fn run(peer: &PeerScene, setup: &Setup, times: u32) -> Result<Outcome> {
    let (map, seconds) = build(peer, setup)?;
    let fragments = map.levels().map(|(lists, _)| lists.len()).collect();
    let mut shadow =
        PrefilteredShadow::new(map).with_accumulate(setup.accumulate).with_splits(setup.splits);
    if let Some(bias) = setup.bias {
        shadow = shadow.with_bias(bias)?;
    }
    let points = if setup.normals { &peer.on_surfaces } else { &peer.points };
    let light = peer.light()?;
    let (found, micros) = match setup.hybrid {
        None => ask(&shadow, points, &light, times),
        Some((rays, reach)) => {
            let near = SceneReference::<f32>::new(peer.traced.clone()).with_start(1e-4);
            let hybrid = HybridShadow::new(shadow, near).with_rays(rays).with_reach(reach)?;
            ask(&hybrid, points, &light, times)
        }
    };
    let half = found.len() / 2;
    let [ground, object] = [0..half, half..found.len()]
        .map(|part| Difference::new(&found[part.clone()], &peer.reference[part]));
    let differences = [ground, object, Difference::new(&found, &peer.reference)];
    Ok(Outcome { differences, micros, seconds, fragments })
}

/// Points are asked again until so many seconds are over: clocks tick.
const LEAST_SECONDS: f64 = 0.05;

fn ask<V: LightVisibility<Value = f32, Error = std::convert::Infallible>>(
    shadow: &V,
    points: &[ShadedPoint],
    light: &AreaLight,
    times: u32,
) -> (Vec<f32>, [f64; 2]) {
    let (ground, object) = points.split_at(points.len() / 2);
    let mut best = [f64::INFINITY; 2];
    let mut found = Vec::new();
    for _ in 0..times.max(1) {
        found.clear();
        for (best, points) in best.iter_mut().zip([ground, object]) {
            let (before, started) = (found.len(), Instant::now());
            let mut rounds = 0;
            while rounds == 0 || started.elapsed().as_secs_f64() < LEAST_SECONDS {
                found.truncate(before);
                let Ok(()) = shadow.visibilities(points, light, &mut found);
                rounds += 1;
            }
            let asked = f64::from(rounds) * points.len().max(1) as f64;
            *best = best.min(started.elapsed().as_secs_f64() * 1e6 / asked);
        }
    }
    (found, best)
}
