//! Shadows without a map.

use std::sync::Arc;

use dsm_core::{AreaLight, Rgb, ShadedPoint, Transmittance};
use dsm_scene::detail::SceneReference;
use dsm_scene::{Scene, TracedScene};
use dsm_trace::detail::CoherentShadow;

use super::any_visibility::{AnyVisibility, Foreign};
use super::handle::Shadow;
use super::statistics::ShadowStatistics;
use crate::error::Result;
use crate::query::coherence_method::CoherenceMethod;
use crate::values::Values;

impl Shadow {
    /// The shadows of a scene's light as they are: `rays` rays from every point
    /// through the scene itself, at least 1; a point light takes one, unless something
    /// moves. What maps are compared with.
    ///
    /// ```
    /// use std::sync::Arc;
    ///
    /// use deepshadow::Shadow;
    /// use deepshadow::scene::{TracedScene, builtin_scene};
    ///
    /// let scene = builtin_scene("spinning-sphere")?;
    /// let traced = Arc::new(TracedScene::new(&scene)?);
    /// let shadow = Shadow::reference(traced, &scene, 16)?;
    /// // The light itself is lit.
    /// assert_eq!(shadow.query(&[scene.light.view.eye])?.rgb(0), [1.0; 3]);
    /// # Ok::<(), deepshadow::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Scene`](crate::Error::Scene) for a light that is none.
    pub fn reference(traced: Arc<TracedScene>, scene: &Scene, rays: u32) -> Result<Self> {
        let light = scene.light.area()?;
        Ok(if scene.is_coloured() {
            Self::of(SceneReference::<Rgb>::new(traced).with_rays(rays), light)
        } else {
            Self::of(SceneReference::<f32>::new(traced).with_rays(rays), light)
        })
    }

    /// The shadows of a scene's light by rays through the scene itself, only where
    /// visibility can have changed from point to point; every ray is traced where
    /// something moves.
    ///
    /// ```
    /// use std::sync::Arc;
    ///
    /// use deepshadow::scene::{TracedScene, builtin_scene};
    /// use deepshadow::{CoherenceMethod, Shadow};
    /// use glam::DVec3;
    ///
    /// let scene = builtin_scene("pipes")?;
    /// let traced = Arc::new(TracedScene::new(&scene)?);
    /// let shadow = Shadow::coherent(traced, &scene, &CoherenceMethod::new(8))?;
    /// let along = |i: u32| DVec3::new(-1.0 + 0.01 * f64::from(i), 0.01, -0.7);
    /// let factors = shadow.query(&(0..200).map(along).collect::<Vec<_>>())?;
    /// assert!(factors.rgb(0) != factors.rgb(199));
    /// let counted = shadow.statistics().coherence.unwrap();
    /// assert!(counted.rays < counted.cells);
    /// # Ok::<(), deepshadow::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Self::reference`].
    pub fn coherent(
        traced: Arc<TracedScene>,
        scene: &Scene,
        method: &CoherenceMethod,
    ) -> Result<Self> {
        let light = scene.light.area()?;
        Ok(if scene.is_coloured() {
            Self::coherent_in::<Rgb>(traced, method, light)
        } else {
            Self::coherent_in::<f32>(traced, method, light)
        })
    }

    fn coherent_in<T: Transmittance>(
        traced: Arc<TracedScene>,
        method: &CoherenceMethod,
        light: AreaLight,
    ) -> Self {
        let settings = method.settings(traced.is_moving());
        let tracer = SceneReference::<T>::new(traced);
        let tracer = match method.start {
            Some(start) => tracer.with_start(start),
            None => tracer,
        };
        let coherent = CoherentShadow::new(tracer, settings);
        Self::new(Box::new(CoherentScene(Foreign(coherent))), light, 0)
    }
}

/// Coherent shadows of a scene, which are counted.
struct CoherentScene<T>(Foreign<CoherentShadow<SceneReference<T>>>);

impl<T: Transmittance> AnyVisibility for CoherentScene<T> {
    fn channels(&self) -> usize {
        self.0.channels()
    }

    fn world(&self, points: &[ShadedPoint], light: &AreaLight, values: &mut Values) -> Result<()> {
        self.0.world(points, light, values)
    }

    fn raster(
        &self,
        points: &[[f64; 3]],
        seed: u64,
        light: &AreaLight,
        values: &mut Values,
    ) -> Result<()> {
        self.0.raster(points, seed, light, values)
    }

    fn statistics(&self) -> ShadowStatistics {
        let coherence = Some(self.0.0.statistics());
        ShadowStatistics { coherence, ..ShadowStatistics::default() }
    }
}
