//! A scene, its map and its camera.

use std::ops::ControlFlow;
use std::sync::Arc;

use anyhow::{Context, Result};
use dsm_core::detail::ShadowLookup;
use dsm_core::{
    AreaLight, BakeSettings, Baker, Footprint, LightVisibility, MapInfo, PixelSampling, Rgb,
    Transmittance,
};
use dsm_io::Limits;
use dsm_io::detail::{BakeOptions, CachedShadow, TileCache, bake};
use dsm_scene::detail::{Camera, Image, RenderSettings, Renderer, SceneReference};
use dsm_scene::{Scene, SceneRasterizer, TracedScene};

/// A square map of `side` pixels and `samples` samples each.
///
/// # Errors
///
/// For numbers that no map has.
pub fn map_settings(side: u32, samples: u32) -> Result<BakeSettings> {
    let mut settings = BakeSettings::new([side; 2])?;
    settings.sampling = PixelSampling::new(samples, 0)?;
    Ok(settings)
}

/// A scene under a point light where its light's centre is, ready to be drawn.
pub struct Stage {
    scene: Scene,
    traced: Arc<TracedScene>,
    camera: Camera,
}

impl Stage {
    /// Seen by the scene's camera at `resolution`.
    ///
    /// # Errors
    ///
    /// If the scene is none.
    pub fn new(scene: Scene, resolution: [u32; 2]) -> Result<Self> {
        let traced = Arc::new(TracedScene::new(&scene)?);
        let camera = Camera { resolution, ..scene.camera };
        Ok(Self { scene, traced, camera })
    }

    /// The same scene through another camera.
    #[must_use]
    pub fn through(self, camera: Camera) -> Self {
        Self { camera, ..self }
    }

    /// The scene.
    #[must_use]
    pub const fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The scene, ready for rays.
    #[must_use]
    pub fn traced(&self) -> &TracedScene {
        &self.traced
    }

    /// Draws with these shadows.
    ///
    /// # Errors
    ///
    /// What the shadow method says.
    pub fn draw<V: LightVisibility>(&self, shadow: &V, settings: &RenderSettings) -> Result<Image>
    where
        V::Error: std::error::Error + Send + Sync + 'static,
    {
        let light = AreaLight::point(self.scene.light.view.eye);
        let camera = self.camera.raster(self.camera.resolution)?;
        let renderer = Renderer::new(Arc::clone(&self.traced), camera, light, settings.clone());
        let image = renderer.render(shadow, |_| ControlFlow::Continue(()))?;
        image.context("nobody broke it off")
    }

    /// Draws with shadow rays, `rays` of them where something moves.
    ///
    /// # Errors
    ///
    /// If the camera is none.
    pub fn draw_traced(&self, rays: u32, settings: &RenderSettings) -> Result<Image> {
        if self.scene.is_coloured() {
            self.draw(
                &SceneReference::<Rgb>::new(Arc::clone(&self.traced)).with_rays(rays),
                settings,
            )
        } else {
            self.draw(
                &SceneReference::<f32>::new(Arc::clone(&self.traced)).with_rays(rays),
                settings,
            )
        }
    }

    /// Draws with lookups in the light's map, once for each footprint.
    ///
    /// # Errors
    ///
    /// If the map cannot be baked.
    pub fn draw_filtered(
        &self,
        map: &BakeSettings,
        footprints: &[Footprint],
        settings: &RenderSettings,
    ) -> Result<Vec<Image>> {
        if self.scene.is_coloured() {
            self.draw_with_map::<Rgb>(map, footprints, settings)
        } else {
            self.draw_with_map::<f32>(map, footprints, settings)
        }
    }

    fn draw_with_map<T: Transmittance>(
        &self,
        map: &BakeSettings,
        footprints: &[Footprint],
        render: &RenderSettings,
    ) -> Result<Vec<Image>> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("map.dsm");
        let raster = self.scene.light.raster(map.size)?;
        let source = SceneRasterizer::<T>::new(&self.scene, raster)?;
        let settings = map.clone().with_camera(raster.shadow_camera());
        let baker = Baker::<T, _>::new(source, settings)?;
        let watch = |_| ControlFlow::Continue(());
        bake(&baker, &path, &BakeOptions::default(), |_| (), watch)?;
        let size = map.size;
        let map = TileCache::new(1 << 30).open::<T>(&path, &Limits::default())?;
        let info: MapInfo = map.reader().metadata().info;
        let lookup = ShadowLookup::new(&info, size)?;
        let drawn = footprints.iter().map(|&footprint| {
            let shadow = CachedShadow::new(map.clone(), lookup.with_footprint(footprint))?;
            self.draw(&shadow, render)
        });
        drawn.collect()
    }
}
