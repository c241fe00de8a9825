//! Hits of a scene for a bake, by ray tracing.

use std::sync::Arc;

use dsm_core::{HitSource, TileHits, TileSamples, Transmittance, ViewRaster};

use crate::error::{Error, Result};
use crate::trace::traced_scene::TracedScene;

/// A scene as a shadow camera sees it, ray by ray.
///
/// ```
/// use dsm_core::{HitSource, PixelSampling, TileHits, TileSamples};
/// use dsm_scene::detail::SceneHitSource;
/// use dsm_scene::{TracedScene, builtin_scene};
///
/// let scene = builtin_scene("spinning-sphere")?;
/// let traced = TracedScene::new(&scene)?;
/// let source = SceneHitSource::new(traced, scene.light.raster([32, 32])?);
///
/// let sampling = PixelSampling::new(4, 0)?;
/// let camera = source.raster().shadow_camera();
/// let samples = TileSamples::new(&sampling, [0, 0], [32, 32], Some((&camera, [32, 32])))?;
/// let mut hits = TileHits::<f32>::new(samples.len());
/// source.hits(&samples, &mut hits)?;
/// // The floor, and in some pixels the spheres above it.
/// assert!(hits.surface_count() as u32 > samples.len());
/// # Ok::<(), dsm_scene::Error>(())
/// ```
pub struct SceneHitSource {
    scene: Arc<TracedScene>,
    raster: ViewRaster,
    near: f64,
}

impl SceneHitSource {
    /// A source of hits of `scene` through `raster`.
    #[must_use]
    pub fn new(scene: impl Into<Arc<TracedScene>>, raster: ViewRaster) -> Self {
        Self { scene: scene.into(), raster, near: 0.0 }
    }

    /// Leaves out occluders at `depth` or nearer: those between the light and a
    /// camera that was moved back from it.
    #[must_use]
    pub fn beyond(self, depth: f32) -> Self {
        let near = if depth > 0.0 { f64::from(depth.next_up()) } else { 0.0 };
        Self { near, ..self }
    }

    /// The raster of the shadow camera.
    #[must_use]
    pub fn raster(&self) -> &ViewRaster {
        &self.raster
    }
}

impl<T: Transmittance> HitSource<T> for SceneHitSource {
    type Error = Error;

    fn hits(&self, samples: &TileSamples, hits: &mut TileHits<T>) -> Result<()> {
        let mut tracer = self.scene.tracer();
        let to_camera = self.raster.basis().transpose();
        let mut found = Vec::new();
        for (index, point) in (0..).zip(samples.points()) {
            let ray = self.raster.ray(point.x, point.y, f64::from(point.time));
            let ray = ray.within(self.near, f64::INFINITY);
            found.clear();
            tracer.surfaces(&ray, |hit, surface| {
                found.push((*hit, surface));
                Ok(())
            })?;
            for (hit, surface) in &found {
                let normal = if hits.wants_normals() { tracer.normal(&ray, hit) } else { None };
                match normal {
                    Some(normal) => {
                        let normal = (to_camera * normal).as_vec3();
                        hits.push_surface_with_normal(index, *surface, normal)?;
                    }
                    None => hits.push_surface(index, *surface)?,
                }
            }
            if hits.wants_media() {
                tracer
                    .media(&ray, |column, factor| Ok(hits.push_volume(index, column, factor)?))?;
            }
        }
        Ok(())
    }

    fn has_media(&self) -> bool {
        self.scene.has_media()
    }
}
