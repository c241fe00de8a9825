//! What was measured, each once.

use std::sync::Arc;

use anyhow::{Context, Result};
use dsm_scene::detail::SceneReference;

use super::maps::{Map, Method};
use super::stage::{Factors, Stage};
use super::{Difference, Effort};
use crate::figures::machine;

/// What was measured of one method under one light.
#[derive(Clone, Debug, PartialEq)]
pub struct Shadowed {
    /// The method.
    pub method: Method,
    /// Seconds of one processor for the map, and its layers.
    pub map: (f64, usize),
    /// The bias of PCF in scene units, 0 for a pixel's side, or the threshold of
    /// the paper's tracing in sides of a pixel: the one closest to traced shadows.
    pub knob: f64,
    /// Its shadow factors.
    pub factors: Factors,
    /// How far they are from traced ones.
    pub difference: Difference,
}

/// A scene under one light, with traced shadows and by every method.
#[derive(Clone, Debug, PartialEq)]
pub struct Lit {
    /// The stage, by its place.
    pub stage: usize,
    /// The light's radius.
    pub radius: f64,
    /// Traced through the scene.
    pub reference: Factors,
    /// By the methods, in their order.
    pub shadows: Vec<Shadowed>,
}

impl Lit {
    /// What one method made.
    ///
    /// # Errors
    ///
    /// If it was not measured.
    pub fn by(&self, method: Method) -> Result<&Shadowed> {
        let found = self.shadows.iter().find(|shadowed| shadowed.method == method);
        found.with_context(|| format!("{} was not measured", method.name()))
    }
}

/// All scenes, and what was measured of them.
pub struct Study {
    /// How much is measured.
    pub effort: Effort,
    /// The scenes.
    pub stages: Vec<Stage>,
    measured: Vec<Lit>,
}

impl Study {
    /// Opens the scenes.
    ///
    /// # Errors
    ///
    /// If one is none.
    pub fn new(effort: Effort) -> Result<Self> {
        let stages = Stage::all(effort.image)?;
        Ok(Self { effort, stages, measured: Vec::new() })
    }

    /// A scene under a light of this radius, by all methods.
    ///
    /// # Errors
    ///
    /// What the methods say.
    pub fn lit(&mut self, stage: usize, radius: f64) -> Result<&Lit> {
        let known = self.measured.iter().position(|m| m.stage == stage && m.radius == radius);
        let index = match known {
            Some(index) => index,
            None => {
                let lit = self.measure(stage, radius)?;
                self.measured.push(lit);
                self.measured.len() - 1
            }
        };
        Ok(&self.measured[index])
    }

    fn measure(&self, stage: usize, radius: f64) -> Result<Lit> {
        let reference = self.reference(stage, radius)?;
        let shadows = Method::ALL.map(|method| {
            let side = match method {
                Method::Fragments => self.effort.fragment_map,
                _ => self.effort.map,
            };
            self.shadowed(stage, radius, method, side, &reference)
        });
        let shadows = shadows.into_iter().collect::<Result<_>>()?;
        Ok(Lit { stage, radius, reference, shadows })
    }

    /// Shadows traced through the scene, to the samples of the light that all
    /// methods take.
    ///
    /// # Errors
    ///
    /// If the light is none.
    pub fn reference(&self, stage: usize, radius: f64) -> Result<Factors> {
        let stage = &self.stages[stage];
        let light = stage.light(radius).area()?;
        let tracer =
            SceneReference::<f32>::new(Arc::clone(&stage.traced)).with_rays(self.effort.rays);
        Ok(stage.factors(&tracer, &light))
    }

    /// One method with a map of this size, its knob set by the result.
    ///
    /// # Errors
    ///
    /// What the method says.
    pub fn shadowed(
        &self,
        stage: usize,
        radius: f64,
        method: Method,
        side: u32,
        reference: &Factors,
    ) -> Result<Shadowed> {
        let stage = &self.stages[stage];
        let light = stage.light(radius).area()?;
        let map = Map::new(&stage.scene, &stage.light(radius), method, side)?;
        let tried = map.knobs().iter().map(|&knob| {
            let factors = map.with_shadow(&light, self.effort.rays, knob, |shadow| {
                stage.factors(shadow, &light)
            })?;
            let difference = Difference::new(&factors.values, &reference.values);
            let map = (map.seconds, map.layers);
            Ok(Shadowed { method, map, knob, factors, difference })
        });
        let tried = tried.collect::<Result<Vec<_>>>()?.into_iter();
        let best = tried.min_by(|a, b| a.difference.mean.total_cmp(&b.difference.mean));
        best.context("nothing was tried")
    }

    /// What all pages say of how they were made.
    #[must_use]
    pub fn parameters(&self) -> String {
        let Effort { image: [width, height], rays, map, fragment_map, .. } = &self.effort;
        format!(
            "Pictures of {width} × {height} pixels, one point each, {rays} light samples a point, \
             the same in all pictures of a scene. Maps of layers: {map} × {map} pixels, one ray \
             each, tolerance 0.02, 4 resets; of fragments: {fragment_map} × {fragment_map} pixels \
             of 8 × 8 places, all layers. Disk lights 5 units from what they light. Times are \
             those of one processor's work, all threads added. {}.",
            machine()
        )
    }
}
