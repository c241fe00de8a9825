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
mod map_view;
mod merge;
mod prefilter_map;
mod query;
mod shadow;
mod shadow_map;
mod stated_error;
mod values;

pub use dsm_core as visibility;
pub use dsm_io as files;
pub use dsm_io::dsm_remote::RemoteOptions;
pub use dsm_scene as scene;
pub use glam;

pub use bake::occluders::{AnyHitSource, Occluders, ThroughView};
pub use bake::{
    report::BakeReport,
    settings::{Bake, Channels},
};
pub use bake_map::bake;
pub use error::Error;
pub use file::open_options::OpenOptions;
pub use kind::Kind;
pub use merge::merge;
pub use mtsm::detail::LeafRule;
pub use query::attenuation_method::AttenuationMethod;
pub use query::coherence_method::CoherenceMethod;
pub use query::settings::Query;
pub use query::trace_method::{FarTable, TraceMethod};
pub use query::{filter_method::FilterMethod, hybrid_method::HybridMethod, method::Method};
pub use query::{
    method_options::MethodOptions, pcf_method::PcfMethod, prefilter_method::PrefilterMethod,
};
pub use shadow::{handle::Shadow, statistics::ShadowStatistics};
pub use shadow_map::ShadowMap;
pub use shadow_maps::detail::{Accumulate, Epsilon, PrefilterSettings};
pub use values::Values;

/// Parts that the other crates of this family stand on. They may change with any
/// version.
#[doc(hidden)]
pub mod detail {
    pub use crate::{
        bake::occluders::SourceError,
        error::Result,
        map_view::MapView,
        shadow::plain::{PlainShadow, plain_shadow},
        stated_error::StatedError,
    };
}
