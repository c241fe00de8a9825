//! Hits of a scene for a bake, by rasterisation.

use dsm_core::{HitSource, TileHits, TileSamples, Transmittance, ViewRaster};
use glam::{DAffine3, DVec3, Vec2};

use super::rasterizer::{Rasterizer, RasterizerBuilder};
use super::rays::Rays;
use super::segment::RaySegment;
use super::triangle::RayTriangle;
use crate::curves::Curves;
use crate::error::Result;
use crate::hit_source::SceneHitSource;
use crate::mesh::TriangleMesh;
use crate::scene::{Object, Scene, Shape};
use crate::trace::scaled;
use crate::trace::traced_scene::TracedScene;

/// A scene as a shadow camera sees it, block by block: a [`Rasterizer`] for all
/// that it supports, a ray tracer for the rest.
///
/// Strands and meshes are rasterised; surfaces whose opacity changes from place
/// to place, media, and objects that turn while the shutter is open are traced.
/// Hits are those of [`SceneHitSource`], but for rays that graze something: up
/// to rounding in `f32`.
///
/// ```
/// use dsm_core::{HitSource, PixelSampling, TileHits, TileSamples};
/// use dsm_scene::{SceneRasterizer, builtin_scene};
///
/// let scene = builtin_scene("hairball")?;
/// let raster = scene.light.raster([16, 16])?;
/// let source = SceneRasterizer::<f32>::new(&scene, raster)?;
///
/// let sampling = PixelSampling::new(4, 0)?;
/// let camera = raster.shadow_camera();
/// let samples = TileSamples::new(&sampling, [0, 0], [16, 16], Some((&camera, [16, 16])))?;
/// let mut hits = TileHits::new(samples.len());
/// source.hits(&samples, &mut hits)?;
/// assert!(hits.surface_count() as u32 > samples.len());
/// # Ok::<(), dsm_scene::Error>(())
/// ```
pub struct SceneRasterizer<T: Transmittance> {
    rasterizer: Rasterizer<T>,
    /// The objects that are ray traced.
    rest: Option<SceneHitSource>,
    view: ViewRaster,
}

impl<T: Transmittance> SceneRasterizer<T> {
    /// A source of hits of `scene` through `view`. O(n) for n primitives that are
    /// rasterised, O(n log n) for those that are traced.
    ///
    /// # Errors
    ///
    /// [`crate::Error::Malformed`] for an object that [`Object::check`]
    /// refuses, [`crate::Error::Core`] for more than 2²⁷ primitives
    /// of one kind.
    pub fn new(scene: &Scene, view: ViewRaster) -> Result<Self> {
        let mut builder = RasterizerBuilder::of_view(&view);
        let mut rest = Vec::new();
        for object in &scene.objects {
            let object = object.clone().check()?;
            if !add(&mut builder, &view, &object) {
                rest.push(object);
            }
        }
        let rest = Scene { objects: rest, ..scene.clone() };
        let rest = if rest.objects.is_empty() {
            None
        } else {
            Some(SceneHitSource::new(TracedScene::new(&rest)?, view))
        };
        Ok(Self { rasterizer: builder.build()?, rest, view })
    }

    /// Leaves out occluders at `depth` or nearer: those between the light and a
    /// camera that was moved back from it.
    #[must_use]
    pub fn beyond(self, depth: f32) -> Self {
        let rest = self.rest.map(|rest| rest.beyond(depth));
        Self { rasterizer: self.rasterizer.beyond(depth), rest, ..self }
    }

    /// The raster of the shadow camera.
    #[must_use]
    pub fn raster(&self) -> &ViewRaster {
        &self.view
    }
}

impl<T: Transmittance> HitSource<T> for SceneRasterizer<T> {
    type Error = crate::Error;

    fn hits(&self, samples: &TileSamples, hits: &mut TileHits<T>) -> Result<()> {
        self.rasterizer.hits(samples, hits)?;
        self.rest.as_ref().map_or(Ok(()), |rest| rest.hits(samples, hits))
    }

    fn has_media(&self) -> bool {
        self.rest.as_ref().is_some_and(HitSource::<T>::has_media)
    }
}

/// Adds an object to the rasteriser, if it can take it.
fn add<T: Transmittance>(
    builder: &mut RasterizerBuilder<T>,
    view: &ViewRaster,
    object: &Object,
) -> bool {
    let Some(keys) = straight(object) else { return false };
    let basis = view.basis().transpose();
    let to_camera = DAffine3::from_mat3_translation(basis, -(basis * view.eye()));
    let keys = keys.map(|to_world| to_camera * to_world);
    let opacity = |own: f32| scaled::<T>(object.opacity, own);
    let RasterizerBuilder { rays, .. } = *builder;
    match &*object.shape {
        Shape::Curves(curves) => {
            let Some(own) = curves.even_opacity() else { return false };
            if object.is_moving() {
                let strands = strands(&rays, curves, keys);
                builder.moving_segments.extend(&rays, opacity(own), strands);
            } else {
                let strands = strands(&rays, curves, [keys[0]]);
                builder.segments.extend(&rays, opacity(own), strands);
            }
        }
        Shape::Mesh(mesh) => {
            if !mesh.is_even() {
                return false;
            }
            let materials = mesh.alphas().len().max(1) as u32;
            for material in 0..materials {
                let own = mesh.alphas().get(material as usize);
                let opacity = opacity(own.map_or(1.0, |alpha| alpha.opacity(Vec2::ZERO)));
                if object.is_moving() {
                    let all = triangles(mesh, material, keys);
                    let all = all.map(|corners| RayTriangle::new(&rays, corners));
                    builder.moving_triangles.extend(&rays, opacity, all);
                } else {
                    let all = triangles(mesh, material, [keys[0]]);
                    let all = all.map(|corners| RayTriangle::new(&rays, corners));
                    builder.triangles.extend(&rays, opacity, all);
                }
            }
        }
        Shape::Volume(_) => return false,
    }
    true
}

/// Object to world where the shutter opens and closes, if every point goes
/// straight and evenly between.
fn straight(object: &Object) -> Option<[DAffine3; 2]> {
    let keys = [0.0, 1.0].map(|time| object.to_world(time));
    if !object.is_moving() {
        return Some(keys);
    }
    let bounds = object.shape.bounds();
    if bounds.is_empty() {
        return Some(keys);
    }
    let corners = [bounds.min, bounds.max, DVec3::new(bounds.min.x, bounds.max.y, bounds.min.z)];
    let even = [0.25, 0.5, 0.75].into_iter().all(|time| {
        let there = object.to_world(time);
        corners.into_iter().chain([bounds.centre()]).all(|corner| {
            let [open, close] = keys.map(|key| key.transform_point3(corner));
            let off = there.transform_point3(corner).distance(open.lerp(close, time));
            off <= 1e-9 * (open.length() + close.length())
        })
    });
    even.then_some(keys)
}

/// All segments as the rays see them.
fn strands<const KEYS: usize>(
    rays: &Rays,
    curves: &Curves,
    keys: [DAffine3; KEYS],
) -> impl Iterator<Item = RaySegment<KEYS>> {
    (0..curves.segments().len()).map(move |index| {
        let ends = curves.segment(index);
        let in_camera_space = keys.map(|key| {
            // A similarity: every axis is as long.
            let scale = key.matrix3.x_axis.length();
            ends.map(|(end, radius)| {
                (key.transform_point3(end.as_dvec3()), (f64::from(radius) * scale) as f32)
            })
        });
        RaySegment::new(rays, in_camera_space, curves.is_joined(index))
    })
}

/// The corners in camera space of all triangles of a material.
fn triangles<const KEYS: usize>(
    mesh: &TriangleMesh,
    material: u32,
    keys: [DAffine3; KEYS],
) -> impl Iterator<Item = [[DVec3; 3]; KEYS]> {
    let of = |index: usize| mesh.triangle_alphas().get(index).copied().unwrap_or(0);
    (0..mesh.triangles().len()).filter(move |&index| of(index) == material).map(move |index| {
        let corners = mesh.corners(index);
        keys.map(|key| corners.map(|corner| key.transform_point3(corner.as_dvec3())))
    })
}
