//! What is lit, and the points that a camera sees of it.

use std::convert::Infallible;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use anyhow::{Context, Result};
use dsm_core::{AreaLight, Facing, LightExtent, LightVisibility, PixelSampling, Rgb, ShadedPoint};
use dsm_scene::detail::{Image, RenderSettings, Renderer, load_shape};
use dsm_scene::{
    Light, Motion, Object, Scene, Shape, TracedScene, Transform, TriangleMesh, builtin_scene,
};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::figures::seconds;

/// Points that one task asks for.
const CHUNK: usize = 64;

/// A method of making shadows.
pub(crate) type Shadow<'a> = dyn LightVisibility<Value = f32, Error = Infallible> + 'a;

/// The shadow factors of a picture, and what they took.
#[derive(Clone, Debug, PartialEq)]
pub struct Factors {
    /// Of every point.
    pub values: Vec<f32>,
    /// Seconds of one processor.
    pub seconds: f64,
}

/// A scene that is seen by its camera.
pub struct Stage {
    /// The scene's name.
    pub name: &'static str,
    /// The scene; the light's outline is not the one that is measured.
    pub scene: Scene,
    /// The same, ready for rays.
    pub traced: Arc<TracedScene>,
    /// What the camera sees, in scanline order.
    pub points: Vec<ShadedPoint>,
    /// The same with what they lie on, as pictures tell it.
    pub surfaces: Vec<ShadedPoint>,
    /// The pixel of each point.
    pixels: Vec<usize>,
    image: [u32; 2],
}

impl Stage {
    /// A head with a pony tail, a crown of leaves and a ball of hair: like the
    /// paper's Shrek, palm and fur ball. Without the head where there are no
    /// models.
    ///
    /// # Errors
    ///
    /// If a scene is none.
    pub fn all(image: [u32; 2]) -> Result<Vec<Self>> {
        let scenes = [
            ("head", head()?),
            ("foliage", Some(builtin_scene("foliage")?)),
            ("hairball", Some(builtin_scene("hairball")?)),
        ];
        let stages = scenes.into_iter().filter_map(|(name, scene)| Some((name, scene?)));
        stages.map(|(name, scene)| Self::new(name, scene, image)).collect()
    }

    /// One scene in a picture of this size.
    ///
    /// # Errors
    ///
    /// If the scene has no camera or no light.
    pub fn new(name: &'static str, scene: Scene, image: [u32; 2]) -> Result<Self> {
        let traced = Arc::new(TracedScene::new(&scene)?);
        let mut settings = RenderSettings::new(1, 0)?;
        settings.sampling = PixelSampling::centre();
        settings.factor = true;
        let asked = Asked::default();
        let camera = scene.camera.raster(image)?;
        let renderer = Renderer::new(Arc::clone(&traced), camera, scene.light.area()?, settings);
        let numbers = renderer.render(&asked, |_| ControlFlow::Continue(()))?;
        let numbers = numbers.context("nobody broke it off")?;
        let asked = asked.0.into_inner().unwrap_or_else(PoisonError::into_inner);
        let (mut surfaces, mut pixels) = (Vec::new(), Vec::new());
        for (pixel, [number, ..]) in numbers.pixels().iter().enumerate() {
            if let Some(&point) = (*number as usize).checked_sub(2).and_then(|at| asked.get(at)) {
                surfaces.push(point);
                pixels.push(pixel);
            }
        }
        let unknown = |point: &ShadedPoint| ShadedPoint { facing: Facing::Light, ..*point };
        let points = surfaces.iter().map(unknown).collect();
        Ok(Self { name, scene, traced, points, surfaces, pixels, image })
    }

    /// The scene's light as a disk.
    #[must_use]
    pub const fn light(&self, radius: f64) -> Light {
        Light { extent: LightExtent::disk(radius), ..self.scene.light }
    }

    /// Triangles and segments of strands.
    #[must_use]
    pub fn primitives(&self) -> usize {
        let objects = self.scene.objects.iter();
        let counts = objects.map(|object| match &*object.shape {
            Shape::Mesh(mesh) => mesh.triangles().len(),
            Shape::Curves(curves) => curves.segments().len(),
            Shape::Volume(_) => 0,
        });
        counts.sum()
    }

    /// The points of every so manieth block of `side` × `side` pixels, block by block.
    #[must_use]
    pub(crate) fn blocks(&self, side: usize, every: usize) -> Vec<Vec<ShadedPoint>> {
        let [width, height] = self.image.map(|pixels| pixels as usize);
        let [columns, rows] = [width, height].map(|pixels| pixels.div_ceil(side));
        let mut blocks = vec![Vec::new(); columns * rows];
        for (&pixel, &point) in self.pixels.iter().zip(&self.surfaces) {
            blocks[pixel / width / side * columns + pixel % width / side].push(point);
        }
        let full = blocks.into_iter().filter(|block| !block.is_empty());
        full.step_by(every).collect()
    }

    /// The shadow factors of all points, and the processors' time for them.
    #[must_use]
    pub fn factors(&self, shadow: &Shadow<'_>, light: &AreaLight) -> Factors {
        Self::factors_of(&self.points, shadow, light)
    }

    /// The same of any points.
    #[must_use]
    pub(crate) fn factors_of(
        points: &[ShadedPoint],
        shadow: &Shadow<'_>,
        light: &AreaLight,
    ) -> Factors {
        let start = Instant::now();
        let chunks = points.par_chunks(CHUNK).map(|points| {
            let (before, mut values) = (seconds(start), Vec::with_capacity(points.len()));
            let Ok(()) = shadow.visibilities(points, light, &mut values);
            (values, seconds(start) - before)
        });
        let chunks: Vec<_> = chunks.collect();
        let seconds = chunks.iter().map(|(_, seconds)| seconds).sum();
        Factors { values: chunks.into_iter().flat_map(|(values, _)| values).collect(), seconds }
    }

    /// The picture of these factors: white where nothing is seen.
    ///
    /// # Errors
    ///
    /// None for the stage's own factors.
    pub fn picture(&self, factors: &Factors) -> Result<Image> {
        let mut pixels = vec![[1.0; 3]; self.image.iter().product::<u32>() as usize];
        for (&pixel, &value) in self.pixels.iter().zip(&factors.values) {
            pixels[pixel] = [value; 3];
        }
        Image::new(self.image, pixels).context("one value a pixel")
    }
}

/// Keeps the points that it is asked for, and answers with 2 more than their
/// numbers: 1 is what a picture shows where there is nothing.
#[derive(Default)]
struct Asked(Mutex<Vec<ShadedPoint>>);

impl Asked {
    fn keep(&self, point: ShadedPoint) -> f32 {
        let mut points = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        points.push(point);
        (points.len() + 1) as f32
    }
}

impl LightVisibility for Asked {
    type Value = f32;
    type Error = Infallible;

    fn visibility(&self, position: DVec3, _: &AreaLight, seed: u64) -> Result<f32, Infallible> {
        Ok(self.keep(ShadedPoint { position, facing: Facing::Light, seed }))
    }

    fn visibilities(
        &self,
        points: &[ShadedPoint],
        _: &AreaLight,
        values: &mut Vec<f32>,
    ) -> Result<(), Infallible> {
        values.extend(points.iter().map(|&point| self.keep(point)));
        Ok(())
    }
}

/// A head and its hair on a floor, two units high, lit and seen as the built-in
/// scenes are; none where the models are not.
fn head() -> Result<Option<Scene>> {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data/hair"));
    let load = |name: &str| load_shape(&folder.join(name));
    if !folder.join("ponytail.hair").exists() {
        return Ok(None);
    }
    let scale = 1.0 / 64.0;
    let lift = Transform { translate: DVec3::Y * 0.06, rotate: DVec3::ZERO, scale };
    let placed = |shape| Object { motion: vec![Motion::still(lift)], ..Object::new(shape) };
    let corner = |x, z| Vec3::new(x, 0.0, z) * 8.0;
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let corners = corners.map(|(x, z)| corner(x, z)).to_vec();
    let floor = TriangleMesh::new(corners, vec![[0, 2, 1], [0, 3, 2]])?;
    let objects = vec![
        placed(load("ponytail.hair")?).with_opacity(Rgb::new(0.5, 0.5, 0.5)),
        placed(load("ponytail_head.obj")?),
        Object::new(Shape::Mesh(floor)),
    ];
    let like = builtin_scene("hairball")?;
    Ok(Some(like.with_objects(objects)))
}
