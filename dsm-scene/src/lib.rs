//! Scenes of meshes, curves and volumes, from files or made here, and the hits of
//! rays through them.
//!
//! ```
//! use dsm_core::{Ray, RayHits};
//! use dsm_scene::{Object, Scene, Shape, TracedScene, TriangleMesh};
//! use glam::{DVec3, Vec3};
//!
//! let corners = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
//! let mesh = TriangleMesh::new(corners, vec![[0, 1, 2]])?;
//! let scene = Scene::of_objects(vec![Object::new(Shape::Mesh(mesh))]);
//! let traced = TracedScene::new(&scene)?;
//!
//! let ray = Ray::new(DVec3::new(0.2, 0.2, 3.0), DVec3::NEG_Z);
//! let mut hits = RayHits::<f32>::default();
//! traced.tracer().hits(&ray, &mut hits)?;
//! assert_eq!(hits.surfaces()[0].depth, 3.0);
//! # Ok::<(), dsm_scene::Error>(())
//! ```

mod alpha;
mod bounds;
mod builtin;
mod curves;
mod error;
mod file;
mod hit_source;
mod load;
mod mesh;
mod raster;
mod reference;
mod render;
mod scene;
mod trace;
mod transform;
mod view;
mod volume;

pub use alpha::{Alpha, AlphaMode, AlphaTexture, Wrap};
pub use builtin::{BUILTIN_SCENES, builtin_scene};
pub use curves::Curves;
pub use error::{Error, Result};
pub use file::{SceneOptions, open_scene, open_scene_with};
pub use hit_source::SceneHitSource;
pub use load::load_shape;
pub use load::vdb::choice::GridChoice;
pub use mesh::TriangleMesh;
pub use raster::scene_rasterizer::SceneRasterizer;
pub use reference::SceneReference;
pub use render::{Image, ImageDifference, RenderSettings, Renderer};
pub use scene::{Object, Scene, Shape};
pub use trace::TracedScene;
pub use transform::{Motion, Transform};
pub use view::{Camera, Light, LightOutline};
pub use volume::{Volume, VolumeBuilder};

/// Parts that the other crates of this family stand on. They may change with any
/// version.
#[doc(hidden)]
pub mod detail {
    pub use crate::bounds::Bounds;
    pub use crate::error::Place;
    pub use crate::load::vdb::volume_from_bytes;
    pub use crate::load::{load_curves, load_mesh, load_volume};
    pub use crate::raster::rasterizer::{Rasterizer, RasterizerBuilder};
    pub use crate::raster::segment::Segment;
    pub use crate::render::srgb_code;
    pub use crate::trace::Tracer;
}
