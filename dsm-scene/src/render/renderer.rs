//! Path tracing of a scene with a shadow method.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use dsm_core::detail::random::golden;
use dsm_core::{
    AreaLight, Facing, LightVisibility, PixelSampling, Progress, ShadedPoint, TileSamples,
    Transmittance, ViewRaster,
};
use glam::DVec3;
use rayon::prelude::*;

use super::image::Image;
use super::interaction::{Interaction, Material, PathTracer};
use super::sampler::{Sampler, spread_otherwise};
use super::shading::radiance;
use crate::error::Result;
use crate::trace::traced_scene::TracedScene;

/// Width and height of what one task renders, in pixels.
const BLOCK: u32 = 16;

/// Camera rays whose points are handed to a method together, but for those of one row.
const TOGETHER: u32 = 1 << 14;

/// The contents and the sampling of a picture.
///
/// ```
/// use dsm_scene::detail::RenderSettings;
///
/// let settings = RenderSettings::new(16, 0)?.with_factor(true);
/// assert!(settings.factor && settings.self_shadowing);
/// # Ok::<(), dsm_scene::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct RenderSettings {
    /// The camera rays of a pixel, each with a position, a time and an end of its
    /// own.
    pub sampling: PixelSampling,
    /// Seed that tells pictures apart that share their sample positions.
    pub seed: u64,
    /// True for the shadow factor alone, unshaded; 1 where the camera sees nothing.
    pub factor: bool,
    /// True for shadows on strands and media too: without, only surfaces receive
    /// them.
    pub self_shadowing: bool,
}

impl RenderSettings {
    /// Settings of shaded pictures of `samples` camera rays a pixel, with all
    /// shadows.
    ///
    /// # Errors
    ///
    /// [`crate::Error::Core`] unless there are 1 to 4096.
    pub fn new(samples: u32, seed: u64) -> Result<Self> {
        let sampling = PixelSampling::new(samples, seed)?;
        Ok(Self { sampling, seed, factor: false, self_shadowing: true })
    }

    /// Sets the seed that tells pictures apart.
    #[must_use]
    pub fn with_seed(self, seed: u64) -> Self {
        Self { seed, ..self }
    }

    /// Sets whether the picture is the shadow factor alone.
    #[must_use]
    pub fn with_factor(self, factor: bool) -> Self {
        Self { factor, ..self }
    }

    /// Sets whether strands and media receive shadows too.
    #[must_use]
    pub fn with_self_shadowing(self, self_shadowing: bool) -> Self {
        Self { self_shadowing, ..self }
    }
}

/// A path tracer of a scene under one light.
///
/// Every camera ray ends at one place: a surface, a strand or a point in a
/// medium, sampled as often as its share of what the ray sees. There the shadow
/// factor is queried, and the light goes on by Lambert's law from surfaces,
/// by Kajiya and Kay's model (1989) from strands, and evenly from media. The
/// light does not get weaker with distance; what it does not reach is black, as
/// is what lies behind everything.
///
/// Strands are shaded on the side of the light. The same arguments give the
/// same picture, whatever the number of threads.
///
/// ```
/// use std::sync::Arc;
///
/// use dsm_scene::detail::{RenderSettings, Renderer, SceneReference};
/// use dsm_scene::{TracedScene, builtin_scene};
///
/// let scene = builtin_scene("spinning-sphere")?;
/// let traced = Arc::new(TracedScene::new(&scene)?);
/// let camera = scene.camera.raster([32, 18])?;
/// let renderer = Renderer::new(Arc::clone(&traced), camera, scene.light.area()?, RenderSettings::new(4, 0)?);
/// let shadow = SceneReference::<f32>::new(traced).with_rays(4);
/// let Ok(Some(image)) = renderer.render(&shadow, |_| std::ops::ControlFlow::Continue(())) else {
///     panic!("not cancelled");
/// };
/// assert_eq!(image.size(), [32, 18]);
/// assert!(image.is_grey());
/// # Ok::<(), dsm_scene::Error>(())
/// ```
pub struct Renderer {
    scene: Arc<TracedScene>,
    camera: ViewRaster,
    light: AreaLight,
    settings: RenderSettings,
}

impl Renderer {
    /// A renderer of `scene` through `camera`.
    #[must_use]
    pub fn new(
        scene: impl Into<Arc<TracedScene>>,
        camera: ViewRaster,
        light: AreaLight,
        settings: RenderSettings,
    ) -> Self {
        Self { scene: scene.into(), camera, light, settings }
    }

    /// Renders the picture with these shadows, on the threads of the current pool.
    /// `watch` is told the progress before every block, from any thread, and may
    /// cancel: then there is no picture.
    ///
    /// # Errors
    ///
    /// Those of the shadow method.
    pub fn render<V: LightVisibility>(
        &self,
        shadow: &V,
        watch: impl Fn(Progress) -> ControlFlow<()> + Sync,
    ) -> std::result::Result<Option<Image>, V::Error>
    where
        V::Error: Send,
    {
        let size @ [width, height] = self.camera.resolution();
        let columns = width.div_ceil(BLOCK);
        let blocks = u64::from(columns) * u64::from(height.div_ceil(BLOCK));
        let done = AtomicU64::new(0);
        let rendered = (0..blocks)
            .into_par_iter()
            .map(|block| {
                let progress = Progress::new(done.load(Ordering::Relaxed), blocks);
                if watch(progress).is_break() {
                    return Ok(None);
                }
                let corner = [block % u64::from(columns), block / u64::from(columns)];
                let pixels = self.block(corner.map(|at| at as u32 * BLOCK), shadow)?;
                done.fetch_add(1, Ordering::Relaxed);
                Ok(Some(pixels))
            })
            .collect::<std::result::Result<Vec<_>, V::Error>>()?;
        let Some(rendered) = rendered.into_iter().collect::<Option<Vec<_>>>() else {
            return Ok(None);
        };
        let mut pixels = Vec::with_capacity(width as usize * height as usize);
        for row in 0..height {
            for column in (0..columns).map(|column| column * BLOCK) {
                let block = &rendered[((row / BLOCK) * columns + column / BLOCK) as usize];
                let length = BLOCK.min(width - column) as usize;
                let start = (row % BLOCK) as usize * length;
                pixels.extend_from_slice(&block[start..start + length]);
            }
        }
        Ok(Image::new(size, pixels))
    }

    /// The pixels of a block, row by row.
    fn block<V: LightVisibility>(
        &self,
        corner: [u32; 2],
        shadow: &V,
    ) -> std::result::Result<Vec<[f32; 3]>, V::Error> {
        let [width, height] = self.camera.resolution();
        let [columns, rows] = [(width - corner[0]).min(BLOCK), (height - corner[1]).min(BLOCK)];
        let mut tracer = PathTracer::new(&self.scene);
        let mut pixels = Vec::with_capacity((columns * rows) as usize);
        let (mut interactions, mut points, mut factors) = (Vec::new(), Vec::new(), Vec::new());
        // Points come together: methods keep what neighbours share.
        let samples = self.settings.sampling.samples_per_pixel();
        let together = (TOGETHER / columns / samples.max(1)).clamp(1, rows);
        let end = corner[1] + rows;
        for first in (corner[1]..end).step_by(together as usize) {
            interactions.clear();
            points.clear();
            factors.clear();
            let rows = together.min(end - first);
            for y in first..first + rows {
                self.interactions([corner[0], y], columns, &mut tracer, &mut interactions);
            }
            for (interaction, seed) in &interactions {
                points.extend(
                    interaction.as_ref().and_then(|interaction| self.shaded(interaction, *seed)),
                );
            }
            shadow.visibilities(&points, &self.light, &mut factors)?;
            let mut factors = factors.iter().map(|&factor| channels(factor));
            let per_pixel = interactions.len() / (columns * rows) as usize;
            for interactions in interactions.chunks_exact(per_pixel.max(1)) {
                let mut sum = [0.0; 3];
                for (interaction, _) in interactions {
                    let value = self.value(interaction.as_ref(), &mut factors);
                    sum.iter_mut().zip(value).for_each(|(sum, value)| *sum += value);
                }
                pixels.push(sum.map(|sum| (sum / interactions.len() as f64) as f32));
            }
        }
        Ok(pixels)
    }

    /// Appends the interactions of the camera rays of `columns` pixels from `first`
    /// on, each with a seed.
    fn interactions(
        &self,
        first: [u32; 2],
        columns: u32,
        tracer: &mut PathTracer<'_>,
        interactions: &mut Vec<(Option<Interaction>, u64)>,
    ) {
        let sampling = &self.settings.sampling;
        let corner = first.map(|coordinate| coordinate as i32);
        // A row of a block has less samples, and a camera less pixels, than
        // are refused.
        let Ok(samples) = TileSamples::new(sampling, corner, [columns, 1], None) else { return };
        let per_pixel = sampling.samples_per_pixel();
        for (index, point) in (0..).zip(samples.points()) {
            let pixel = [first[0] + index / per_pixel, first[1]];
            let mut sampler = Sampler::of(self.settings.seed, pixel);
            let (start, other_start) = (sampler.unit(), sampler.unit());
            let sample = index % per_pixel;
            let mut sampler = Sampler::of(sampler.bits(), [sample, 0]);
            let ray = self.camera.ray(point.x, point.y, f64::from(point.time));
            let mut first_medium = Some(spread_otherwise(other_start, sample));
            let medium = || first_medium.take().unwrap_or_else(|| sampler.unit());
            let interaction = tracer.interaction(&ray, golden(start, sample.into()), medium);
            interactions.push((interaction, sampler.bits()));
        }
    }

    /// The receiver of an interaction, if it has shadow: on the side of a surface that
    /// is seen, further off than its position may be by rounding, and by twice the ray
    /// offset of [`SceneReference`](crate::reference::SceneReference), so that a surface shades the side that is
    /// turned from the light.
    fn shaded(&self, interaction: &Interaction, seed: u64) -> Option<ShadedPoint> {
        let (off, facing) = match interaction.material {
            Material::Surface { normal } => {
                let rounding = self.scene.rounding(&[self.camera.eye(), interaction.position]);
                (normal * (2.0 * rounding), Facing::Surface(normal))
            }
            _ if !self.settings.self_shadowing => return None,
            Material::Strand { along, radius } => {
                (self.to_light(interaction) * radius, Facing::Strand(along))
            }
            Material::Medium => (DVec3::ZERO, Facing::Light),
        };
        Some(ShadedPoint { position: interaction.position + off, facing, seed })
    }

    fn to_light(&self, interaction: &Interaction) -> DVec3 {
        (self.light.centre() - interaction.position).normalize_or(DVec3::Y)
    }

    /// The light that an interaction adds to its pixel; takes its factor, if it has
    /// one.
    fn value(
        &self,
        interaction: Option<&Interaction>,
        factors: &mut impl Iterator<Item = [f64; 3]>,
    ) -> [f64; 3] {
        let Some(interaction) = interaction else {
            return [f64::from(u8::from(self.settings.factor)); 3];
        };
        let factor = match self.shaded(interaction, 0) {
            Some(_) => factors.next().unwrap_or([1.0; 3]),
            None => [1.0; 3],
        };
        if self.settings.factor {
            return factor;
        }
        let to_eye = (self.camera.eye() - interaction.position).normalize_or(DVec3::Y);
        let radiance = radiance(interaction.material, self.to_light(interaction), to_eye);
        [0, 1, 2].map(|channel| radiance * factor[channel] * interaction.weight[channel])
    }
}

/// A factor's three channels.
fn channels<T: Transmittance>(factor: T) -> [f64; 3] {
    [0, 1, 2].map(|channel| f64::from(factor.channel(channel.min(T::CHANNELS - 1))))
}
