//! Strips of pictures.

use std::ops::ControlFlow;
use std::sync::Arc;

use anyhow::{Context, Result};
use dsm_core::LightVisibility;
use dsm_scene::detail::{Camera, Image, RenderSettings, Renderer, SceneReference};
use dsm_scene::{Scene, TracedScene};

use super::peers::tracer;
use super::scenes::{boxes, scenes};
use super::trial::Attenuated;

/// Width and height of a picture, per unit of scale.
const SIZE: [u32; 2] = [24, 18];

/// A scene that is drawn through a camera.
pub(crate) struct Drawn {
    scene: Scene,
    pub(crate) traced: Arc<TracedScene>,
    camera: Camera,
    settings: RenderSettings,
}

impl Drawn {
    /// Through the scene's own camera.
    pub(crate) fn of(scene: Scene, scale: u32) -> Result<Self> {
        let camera = scene.camera;
        Self::new(scene, camera, SIZE.map(|side| side * scale))
    }

    fn new(scene: Scene, camera: Camera, resolution: [u32; 2]) -> Result<Self> {
        let traced = Arc::new(TracedScene::new(&scene)?);
        // Without the cosine, as in the paper's pictures of the plant.
        let settings = RenderSettings::new(4, 0)?.with_factor(true);
        Ok(Self { scene, traced, camera: Camera { resolution, ..camera }, settings })
    }

    pub(crate) fn draw<V>(&self, shadow: &V) -> Result<Image>
    where
        V: LightVisibility,
        V::Error: std::error::Error + Send + Sync + 'static,
    {
        let camera = self.camera.raster(self.camera.resolution)?;
        let light = self.scene.light.area()?;
        let renderer =
            Renderer::new(Arc::clone(&self.traced), camera, light, self.settings.clone());
        let image = renderer.render(shadow, |_| ControlFlow::Continue(()))?;
        image.context("nobody broke it off")
    }

    fn reference(&self, rays: u32) -> Result<Image> {
        self.draw(&SceneReference::<f32>::new(Arc::clone(&self.traced)).with_rays(rays))
    }
}

fn beside(images: &[Image]) -> Result<Image> {
    Image::beside(images).context("all are as high")
}

/// Rows on top of each other.
fn stacked(rows: &[Image]) -> Result<Image> {
    let width = rows.first().map_or(0, |row| row.size()[0]);
    let height = rows.iter().map(|row| row.size()[1]).sum();
    let pixels = rows.iter().flat_map(|row| row.pixels()).copied().collect();
    Image::new([width, height], pixels).context("all rows are as wide")
}

/// The three scenes: by an attenuation map, by four views, traced.
pub(super) fn methods(scale: u32, [map, view]: [u32; 2], rays: u32) -> Result<Image> {
    let rows = scenes()?.into_iter().map(|(_, scene)| {
        let camera = scene.camera;
        let drawn = Drawn::new(scene, camera, SIZE.map(|side| side * scale))?;
        let map = Attenuated::new(&drawn.scene, map, rays, 1.0)?;
        let views = tracer(&drawn.scene, view, 4)?.with_rays(rays);
        beside(&[drawn.draw(&map.shadow)?, drawn.draw(&views)?, drawn.reference(rays)?])
    });
    stacked(&rows.collect::<Result<Vec<_>>>()?)
}

/// Figure 11: sides that the light hardly sees, and the edge of a shadow from close by, by
/// one texel, by four, by four views and traced.
pub(super) fn artefacts(scale: u32, [map, view]: [u32; 2], rays: u32) -> Result<Image> {
    let (scene, close) = boxes()?;
    let whole = scene.camera;
    let rows = [whole, close].into_iter().map(|camera| {
        let drawn = Drawn::new(scene.clone(), camera, SIZE.map(|side| side * scale))?;
        let map = Attenuated::new(&drawn.scene, map, rays, 1.0)?;
        let four = map.shadow.clone().with_bilinear(true);
        let views = tracer(&drawn.scene, view, 4)?.with_rays(rays);
        let images = [drawn.draw(&map.shadow)?, drawn.draw(&four)?, drawn.draw(&views)?];
        beside(&images.into_iter().chain([drawn.reference(rays)?]).collect::<Vec<_>>())
    });
    stacked(&rows.collect::<Result<Vec<_>>>()?)
}
