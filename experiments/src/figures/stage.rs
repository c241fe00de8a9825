//! What is looked at, and from where.

use anyhow::Result;
use dsm_core::{PixelSampling, Receiver, Rgb, ViewRaster};
use dsm_scene::{Scene, SceneRasterizer, builtin_scene};
use shadow_maps::detail::Blocking;
use shadow_maps::plain::{DepthMap, DepthMapSettings};

/// How much is measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Effort {
    /// Width and height of the deep maps in pixels.
    pub map: u32,
    /// Samples along the side of a pixel.
    pub sides: Vec<u32>,
    /// Width and height of the image whose points are receivers.
    pub image: [u32; 2],
    /// How many receivers' errors are measured.
    pub checked: usize,
    /// Samples a reference takes over a pixel of the map.
    pub reference_samples: u32,
    /// How often every time is taken.
    pub rounds: usize,
    /// How long a method works for one time, in seconds at least.
    pub seconds: f64,
}

impl Effort {
    /// What the paper shows: 2 × 2 to 64 × 64 samples a pixel of 256 × 256.
    #[must_use]
    pub fn full() -> Self {
        Self {
            map: 256,
            sides: vec![2, 4, 8, 16, 32, 64],
            image: [640, 360],
            checked: 2000,
            reference_samples: 1 << 16,
            rounds: 7,
            seconds: 0.15,
        }
    }

    /// As little as still shows the same: seconds instead of minutes.
    #[must_use]
    pub fn small() -> Self {
        Self {
            map: 32,
            sides: vec![2, 4, 8, 16],
            image: [96, 54],
            checked: 150,
            reference_samples: 1 << 12,
            rounds: 3,
            seconds: 0.01,
        }
    }
}

/// How far receivers are moved towards the light, in scene units: what lies on
/// a hair must not be shaded by that hair's own depth.
const BIAS: f32 = 0.01;

/// The ball of hair, its light and the points that a camera sees of it.
pub struct Stage {
    /// How much is measured.
    pub effort: Effort,
    /// The built-in scene `hairball` with opaque hairs, since a plain shadow
    /// map holds no others.
    pub scene: Scene,
    /// The shadow camera's raster.
    pub raster: ViewRaster,
    /// What the shadow camera sees.
    pub source: SceneRasterizer<f32>,
    /// The points that the camera sees and the map covers, in scanline order.
    pub receivers: Vec<Receiver>,
}

impl Stage {
    /// Sets the scene up.
    ///
    /// # Errors
    ///
    /// What the scene's own code says.
    pub fn new(effort: Effort) -> Result<Self> {
        let mut scene = builtin_scene("hairball")?;
        let hairs = scene.objects.swap_remove(0);
        scene.objects.push(hairs.with_opacity(Rgb::new(1.0, 1.0, 1.0)));
        let raster = scene.light.raster([effort.map; 2])?;
        let source = SceneRasterizer::new(&scene, raster)?;
        let receivers = receivers(&scene, effort.image, &raster)?;
        Ok(Self { effort, scene, raster, source, receivers })
    }

    /// Every n-th receiver so that [`Effort::checked`] are left.
    #[must_use]
    pub fn checked(&self) -> Vec<Receiver> {
        let count = self.effort.checked.clamp(1, self.receivers.len().max(1));
        let every = self.receivers.len() as f64 / count as f64;
        (0..count)
            .filter_map(|index| self.receivers.get((index as f64 * every) as usize).copied())
            .collect()
    }
}

fn receivers(scene: &Scene, image: [u32; 2], light: &ViewRaster) -> Result<Vec<Receiver>> {
    let view = scene.camera.raster(image)?;
    let mut settings = DepthMapSettings::new(image, 1)?;
    settings.sampling = PixelSampling::centre();
    settings.blocking = Blocking::Opaque;
    let seen = DepthMap::sample(&SceneRasterizer::<f32>::new(scene, view)?, &settings)?;
    let (camera, size) = (light.shadow_camera(), light.resolution().map(f64::from));
    let mut receivers = Vec::new();
    for y in 0..image[1] {
        for x in 0..image[0] {
            let depth = seen.depth(x, y);
            if depth == f32::INFINITY {
                continue;
            }
            let ray = view.ray(f64::from(x) + 0.5, f64::from(y) + 0.5, 0.5);
            let Some(at) = camera.project(ray.at(depth.into()))? else { continue };
            if (0.0..1.0).contains(&at.x) && (0.0..1.0).contains(&at.y) {
                let position = [(at.x * size[0]) as f32, (at.y * size[1]) as f32];
                let receiver = Receiver::new(position, at.z as f32);
                receivers.push(Receiver { bias: BIAS, ..receiver });
            }
        }
    }
    Ok(receivers)
}
