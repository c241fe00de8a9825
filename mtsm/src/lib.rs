//! Multilayer transparent shadow maps for area lights, after Xie, Tabellion &
//! Pearce, *Soft Shadows by Ray Tracing Multilayer Transparent Shadow Maps* (EGSR
//! 2007).
//!
//! [`MultilayerBaker`] makes [`MultilayerMap`]s (§5) and [`MultilayerDepthMap`]s
//! (§4.2). They answer [`dsm_core::VisibilityField`], the former with their
//! first run of layers, so that the filtered lookup of `dsm-core` serves them as
//! it serves a deep shadow map. [`MultilayerTracer`] traces shadow rays through
//! either ([`dsm_trace`]), and [`SoftPercentageCloser`] filters them instead, as
//! the paper's baseline does (§3).

mod build;
mod depth_layers;
mod layer;
mod layered_pixels;
mod layers_of_pixel;
mod leaf_rule;
mod multilayer_map;
mod multilayer_settings;
mod multilayer_tracer;
mod run_builder;
mod soft_pcf;
mod store;
mod traced_map;

pub use build::MultilayerBaker;
pub use depth_layers::MultilayerDepthMap;
pub use leaf_rule::LeafRule;
pub use multilayer_map::MultilayerMap;
pub use multilayer_settings::MultilayerSettings;
pub use multilayer_tracer::{MultilayerTracer, TraceSettings};
pub use soft_pcf::{FilteredLayers, SoftPercentageCloser};
pub use store::bake::{bake_layers, bake_mtsm};
pub use store::layers::Layers;
pub use store::mtsm::Mtsm;
pub use traced_map::{CachedLayers, TracedMap};

/// Parts that the other crates of this family stand on. They may change with any
/// version.
#[doc(hidden)]
pub mod detail {
    pub use crate::build::BakedLayers;
    pub use crate::depth_layers::DepthLayers;
    pub use crate::layer::{Layer, LayerRun};
    pub use crate::layered_pixels::{LayeredPixels, LayeredPixelsBuilder};
    pub use crate::multilayer_settings::LayeredInfo;
    pub use crate::store::keys::LayeredKeys;
}
