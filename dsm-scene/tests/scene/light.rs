//! The light that a model stops.

use std::path::Path;

use dsm_core::{HitSource, LightExtent, PixelSampling, Projection, TileHits, TileSamples, View};
use dsm_scene::detail::Result;
use dsm_scene::{SceneRasterizer, open_scene};
use glam::DVec3;

const SIDE: u32 = 32;
const SAMPLES: u32 = 64;

/// What a model does to the light.
#[derive(Debug)]
pub(crate) struct Stopped {
    /// The mean that is stopped in the left and the right half of the square.
    pub(crate) halves: [f64; 2],
    pub(crate) warnings: Vec<String>,
}

impl Stopped {
    pub(crate) fn mean(&self) -> f64 {
        (self.halves[0] + self.halves[1]) / 2.0
    }
}

/// The light of an orthographic light at (0, 0, 5) that a file stops over the square
/// [−1, 1]² around the origin: 1 − V(∞), the mean over 32² pixels of 64 rays.
pub(crate) fn stopped_by(path: &Path) -> Result<Stopped> {
    let mut scene = open_scene(path)?;
    scene.light.view = View { eye: DVec3::Z * 5.0, target: DVec3::ZERO, up: DVec3::Y };
    scene.light.projection = Projection::Orthographic { extent: 2.0 };
    scene.light.extent = LightExtent::POINT;
    let raster = scene.light.raster([SIDE; 2])?;
    let source = SceneRasterizer::<f32>::new(&scene, raster)?;
    let sampling = PixelSampling::new(SAMPLES, 1)?;
    let samples = TileSamples::new(&sampling, [0, 0], [SIDE; 2], None)?;
    let mut hits = TileHits::new(samples.len());
    source.hits(&samples, &mut hits)?;
    let mut left = vec![1.0; samples.len() as usize];
    for (sample, hit) in hits.surfaces() {
        left[sample as usize] *= 1.0 - f64::from(hit.opacity);
    }
    let mut halves = [0.0; 2];
    for (left, point) in left.iter().zip(samples.points()) {
        halves[usize::from(point.x >= f64::from(SIDE) / 2.0)] += 1.0 - left;
    }
    let halves = halves.map(|sum| sum / f64::from(SIDE * SIDE * SAMPLES / 2));
    Ok(Stopped { halves, warnings: scene.warnings().to_vec() })
}
