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
mod bricks;
mod builtin;
mod curves;
mod error;
mod file;
mod frame;
mod hit_source;
mod load;
mod mesh;
mod raster;
mod reference;
mod render;
mod scene;
mod scene_memory;
mod scene_options;
mod trace;
mod transform;
mod view;
mod volume;
mod volume_builder;

pub use builtin::builtin_scene;
pub use curves::Curves;
pub use error::Error;
pub use file::open_scene;
pub use mesh::TriangleMesh;
pub use raster::scene_rasterizer::SceneRasterizer;
pub use scene::{Object, Scene, Shape};
pub use scene_memory::SceneMemory;
pub use trace::traced_scene::TracedScene;
pub use transform::{Motion, Transform};
pub use view::Light;
pub use volume::Volume;
pub use volume_builder::VolumeBuilder;

/// Parts that the other crates of this family stand on. They may change with any
/// version.
#[doc(hidden)]
pub mod detail {
    pub use crate::{
        alpha::{Alpha, AlphaMode, AlphaTexture, Wrap},
        bounds::Bounds,
        builtin::BUILTIN_SCENES,
        error::{Place, Result},
        file::open_scene_with,
        frame::{frame_path, has_frame},
        hit_source::SceneHitSource,
        load::{
            load_curves, load_mesh, load_shape, load_volume,
            vdb::{choice::GridChoice, volume_from_bytes},
        },
        raster::{
            rasterizer::{Rasterizer, RasterizerBuilder},
            segment::Segment,
        },
        reference::SceneReference,
        render::{
            image::{Image, ImageDifference},
            png::srgb_code,
            renderer::{RenderSettings, Renderer},
        },
        scene_options::SceneOptions,
        trace::traced_scene::Tracer,
        view::Camera,
    };
}
