//! Shadows without a map.

use std::sync::Arc;

use dsm_core::Rgb;
use dsm_scene::detail::SceneReference;
use dsm_scene::{Scene, TracedScene};

use super::handle::Shadow;
use crate::error::Result;

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
}
