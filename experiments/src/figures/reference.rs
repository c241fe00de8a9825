//! What the light at a receiver is, as nearly as many samples tell.

use anyhow::Result;
use dsm_core::{HitSource, PixelSampling, Receiver, TileHits, TileSamples};
use dsm_scene::SceneRasterizer;
use rayon::prelude::*;

use super::Stage;

/// Pixels of the reference's raster along the side of one of the map.
const FINER: u32 = 8;

/// The light that reaches each receiver through a square one pixel of the map
/// wide around it, by samples of their own, none of which a map has.
///
/// # Errors
///
/// What the scene's own code says.
pub(super) fn references(stage: &Stage, receivers: &[Receiver]) -> Result<Vec<f64>> {
    let size = [stage.effort.map * FINER; 2];
    let view = stage.scene.light.raster(size)?;
    let source = SceneRasterizer::<f32>::new(&stage.scene, view)?;
    let samples = (stage.effort.reference_samples / (FINER * FINER)).max(1);
    let sampling = PixelSampling::new(samples, 0x5eed)?;
    receivers.par_iter().map(|receiver| Ok(light(&source, &sampling, receiver)?)).collect()
}

fn light(
    source: &SceneRasterizer<f32>,
    sampling: &PixelSampling,
    receiver: &Receiver,
) -> Result<f64, dsm_scene::Error> {
    let edge = |axis: usize, sign: f64| {
        (f64::from(receiver.position[axis]) + sign * 0.5) * f64::from(FINER)
    };
    let (start, end) = ([edge(0, -1.0), edge(1, -1.0)], [edge(0, 1.0), edge(1, 1.0)]);
    let min = start.map(|edge| edge.floor() as i32);
    let size = [0, 1].map(|axis| (end[axis].ceil() as i32 - min[axis]) as u32);
    let samples = TileSamples::new(sampling, min, size, None)?;
    let mut hits = TileHits::new(samples.len());
    source.hits(&samples, &mut hits)?;
    let mut left = vec![1.0; samples.len() as usize];
    let depth = receiver.depth - receiver.bias;
    for (sample, hit) in hits.surfaces() {
        if hit.depth <= depth {
            left[sample as usize] *= 1.0 - f64::from(hit.opacity);
        }
    }
    let (mut sum, mut count) = (0.0, 0.0);
    for (point, left) in samples.points().zip(left) {
        let inside = [point.x, point.y]
            .into_iter()
            .enumerate()
            .all(|(axis, at)| (start[axis]..end[axis]).contains(&at));
        if inside {
            sum += left;
            count += 1.0;
        }
    }
    Ok(sum / count)
}
