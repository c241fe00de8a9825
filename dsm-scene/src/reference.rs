//! Ray traced reference shadows: one ray to every sample of the light, and no map.

use std::convert::Infallible;
use std::marker::PhantomData;
use std::sync::Arc;

use dsm_core::detail::Occlusion;
use dsm_core::detail::random::golden;
use dsm_core::{AreaLight, LightVisibility, OcclusionTracer, Ray, ShadedPoint, Transmittance};
use dsm_trace::detail::LightMean;
use glam::DVec3;

use crate::trace::traced_scene::TracedScene;

/// The ray traced reference: shadow rays through a scene, which every map is
/// compared with.
///
/// A receiver is a place on something, whose coordinates were computed in `f64`. Its
/// rays start beyond that thing by the precision of those coordinates: by 2⁻⁴³
/// (some 10⁻¹³) of the largest of them and of those of the scene's objects, wherever the
/// scene stands and however large its unit is. Receivers known less well than that
/// need [`Self::with_start`].
///
/// ```
/// use dsm_core::LightVisibility;
/// use dsm_scene::detail::SceneReference;
/// use dsm_scene::{TracedScene, builtin_scene};
/// use glam::DVec3;
///
/// let scene = builtin_scene("pipes")?;
/// let traced = TracedScene::new(&scene)?;
/// let reference = SceneReference::<f32>::new(traced).with_rays(64);
/// let light = scene.light.area()?;
/// let Ok(lit) = reference.visibility(DVec3::new(6.0, 0.01, 6.0), &light, 0);
/// let Ok(shaded) = reference.visibility(DVec3::new(-0.5, 0.01, -0.7), &light, 0);
/// assert!(lit == 1.0 && shaded < 0.7);
/// # Ok::<(), dsm_scene::Error>(())
/// ```
pub struct SceneReference<T> {
    scene: Arc<TracedScene>,
    rays: u32,
    /// None: as much as rounding.
    start: Option<f64>,
    value: PhantomData<fn() -> T>,
}

impl<T: Transmittance> SceneReference<T> {
    /// A reference of 256 rays a light, which start beyond the surface that the
    /// receiver lies on.
    #[must_use]
    pub fn new(scene: impl Into<Arc<TracedScene>>) -> Self {
        Self { scene: scene.into(), rays: 256, start: None, value: PhantomData }
    }

    /// Sets the number of rays, at least 1. A point light takes one, unless
    /// something moves.
    #[must_use]
    pub fn with_rays(self, rays: u32) -> Self {
        Self { rays: rays.max(1), ..self }
    }

    /// Sets the ray offset: occluders nearer to a receiver than this distance, in
    /// scene units along the ray, do not shade it. At least 0. For receivers whose
    /// positions are rounded to `f32`, some 2⁻²² of the largest coordinate.
    #[must_use]
    pub fn with_start(self, start: f64) -> Self {
        Self { start: Some(start.max(0.0)), ..self }
    }

    fn shadow_ray(&self, receiver: DVec3, light: DVec3, time: f64) -> Ray {
        let start = self.start.unwrap_or_else(|| self.scene.rounding(&[receiver]));
        let start = start / (light - receiver).length();
        Ray::between(receiver, light).within(start, 1.0).at_time(time)
    }
}

impl<T: Transmittance> OcclusionTracer for SceneReference<T> {
    type Value = T;
    type Error = Infallible;

    fn transmittance(&self, receiver: DVec3, light: DVec3, time: f64) -> Result<T, Infallible> {
        Ok(self.scene.tracer().transmittance(&self.shadow_ray(receiver, light, time)))
    }

    fn occlusions(
        &self,
        receiver: &ShadedPoint,
        targets: &[(DVec3, f64)],
        found: &mut Vec<Occlusion<T>>,
    ) -> Result<(), Infallible> {
        let mut tracer = self.scene.tracer();
        found.extend(targets.iter().map(|&(light, time)| {
            let ray = self.shadow_ray(receiver.position, light, time);
            let (transmittance, met) = tracer.occlusion(&ray);
            Occlusion { transmittance, blocker: met.map(|t| ray.at(t)) }
        }));
        Ok(())
    }
}

impl<T: Transmittance> LightVisibility for SceneReference<T> {
    type Value = T;
    type Error = Infallible;

    /// The mean over the light's samples, each at a time of its own.
    fn visibility(&self, receiver: DVec3, light: &AreaLight, seed: u64) -> Result<T, Infallible> {
        let is_point = light.shape() == dsm_core::detail::LightShape::Point;
        let rays = if is_point && !self.scene.is_moving() { 1 } else { self.rays };
        let mut tracer = self.scene.tracer();
        let mut mean = LightMean::new();
        let first = golden(0.0, seed as f64);
        for (index, point) in light.samples(receiver, rays, seed).enumerate() {
            let time = golden(first, index as f64);
            mean.add(tracer.transmittance(&self.shadow_ray(receiver, point, time)));
        }
        Ok(mean.of(rays))
    }
}
