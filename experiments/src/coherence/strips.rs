//! Strips of pictures: figures 13 and 15.

use anyhow::{Context, Result};
use dsm_core::{AreaLight, LightVisibility, ShadedPoint};
use dsm_scene::detail::{Image, SceneReference};
use dsm_trace::detail::{CoherenceSettings, CoherentShadow};
use glam::DVec3;

use crate::attenuation::strips::Drawn;

/// A method whose points all have the same samples.
struct OneSeed<V>(V);

impl<V: LightVisibility> LightVisibility for OneSeed<V> {
    type Value = V::Value;
    type Error = V::Error;

    fn visibility(&self, at: DVec3, light: &AreaLight, _: u64) -> Result<V::Value, V::Error> {
        self.0.visibility(at, light, 0)
    }

    fn visibilities(
        &self,
        points: &[ShadedPoint],
        light: &AreaLight,
        values: &mut Vec<V::Value>,
    ) -> Result<(), V::Error> {
        let points: Vec<_> = points.iter().map(|point| ShadedPoint { seed: 0, ..*point }).collect();
        self.0.visibilities(&points, light, values)
    }
}

/// A scene by coherent sampling of 256 cells; by about as many rays spread over the light,
/// `side` × `side`; by the same, the same for every point; by 1024 rays.
///
/// # Errors
///
/// What drawing says.
pub(super) fn equal_time(drawn: &Drawn, side: u32) -> Result<Image> {
    let rays = || SceneReference::<f32>::new(std::sync::Arc::clone(&drawn.traced));
    let coherent = CoherentShadow::new(rays(), CoherenceSettings::new(16));
    let settings = CoherenceSettings::new(side).with_prediction(false);
    let plain = CoherentShadow::new(rays(), settings);
    let images = [
        drawn.draw(&coherent)?,
        drawn.draw(&plain)?,
        drawn.draw(&OneSeed(plain))?,
        drawn.draw(&rays().with_rays(1024))?,
    ];
    Image::beside(&images).context("all are as high")
}
