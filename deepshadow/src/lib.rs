//! Deep and layered shadow maps of any kind: opened, queried, baked, verified.
//!
//! [`ShadowMap::open`] takes any `.dsm` file. [`bake()`] makes one of a scene, or of
//! whatever [`Occluders`] there are. Everything is owned, `Send` and `Sync`, and
//! cheap to clone, so that a renderer's threads or another language can hold it;
//! kinds of map and numbers of channels are values, not types.

mod bake;
mod bake_map;
mod error;
mod file;
mod kind;
mod kinds;
mod query;
mod shadow;
mod shadow_map;
mod values;

pub use dsm_core as visibility;
pub use dsm_io as files;
pub use dsm_scene as scene;
pub use glam;

pub use bake::{AnyHitSource, Bake, BakeReport, Channels, Occluders, SourceError, ThroughView};
pub use bake_map::bake;
pub use dsm_core::{
    AreaLight, Bias, BiasSummary, Facing, Filter, FilterShape, Footprint, LevelChoice,
    LightVisibility, Progress, Projection, ShadedPoint, Tolerance, View, ViewRaster,
};
pub use error::{Error, Result};
pub use file::OpenOptions;
pub use kind::Kind;
pub use mtsm::LeafRule;
pub use query::{FarTable, FilterMethod, Method, PcfMethod, Query, TraceMethod};
pub use shadow::{PlainShadow, Shadow, ShadowStatistics, plain_shadow, reference_shadow};
pub use shadow_map::ShadowMap;
pub use values::Values;
