//! Shadows without a map.

use std::sync::Arc;

use dsm_core::Rgb;
use dsm_scene::{Scene, SceneReference, TracedScene};

use super::handle::Shadow;
use crate::error::Result;

/// The shadows of a scene's light as they are: `rays` rays from every point
/// through the scene itself, at least 1; a point light takes one, unless something
/// moves. What maps are compared with.
///
/// # Errors
///
/// [`Error::Scene`](crate::Error::Scene) for a light that is none.
pub fn reference_shadow(traced: Arc<TracedScene>, scene: &Scene, rays: u32) -> Result<Shadow> {
    let light = scene.light.area()?;
    Ok(if scene.is_coloured() {
        Shadow::of(SceneReference::<Rgb>::new(traced).with_rays(rays), light)
    } else {
        Shadow::of(SceneReference::<f32>::new(traced).with_rays(rays), light)
    })
}
