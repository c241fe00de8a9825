//! Multilayer transparent shadow maps for area lights, after Xie, Tabellion &
//! Pearce, *Soft Shadows by Ray Tracing Multilayer Transparent Shadow Maps* (EGSR
//! 2007).
//!
//! [`MultilayerBaker`] makes [`MultilayerMap`]s (§5) and multilayer depth maps
//! (§4.2). They answer [`dsm_core::VisibilityField`], the former with their
//! first run of layers, so that the filtered lookup of `dsm-core` serves them as
//! it serves a deep shadow map. The crate `deepshadow` stores them in files, traces
//! shadow rays through either, and filters them as the paper's baseline does (§3).

mod build;
mod depth_layers;
mod layer;
mod layered_pixels;
mod layers_of_pixel;
mod leaf_rule;
mod mean_layers;
mod multilayer_map;
mod multilayer_settings;
mod multilayer_tracer;
mod run_builder;
mod soft_pcf;
mod store;
mod traced_map;

pub use build::MultilayerBaker;
pub use multilayer_map::MultilayerMap;
pub use multilayer_settings::MultilayerSettings;

/// Parts that the other crates of this family stand on. They may change with any
/// version.
#[doc(hidden)]
pub mod detail {
    pub use crate::{
        build::BakedLayers,
        depth_layers::{DepthLayers, MultilayerDepthMap},
        layer::{Layer, LayerRun},
        layered_pixels::{LayeredPixels, LayeredPixelsBuilder},
        leaf_rule::LeafRule,
        multilayer_settings::LayeredInfo,
        multilayer_tracer::{MultilayerTracer, TraceSettings},
        soft_pcf::{FilteredLayers, SoftPercentageCloser},
        store::{
            bake::{bake_layers, bake_mtsm},
            keys::LayeredKeys,
            layers::Layers,
            mtsm::Mtsm,
        },
        traced_map::{CachedLayers, TracedMap},
    };
}
