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
mod leaf_rule;
mod multilayer_map;
mod multilayer_settings;
mod multilayer_tracer;
mod run_builder;
mod soft_pcf;
mod store;

pub use build::{BakedLayers, MultilayerBaker};
pub use depth_layers::{DepthLayers, MultilayerDepthMap};
pub use layer::{Layer, LayerRun};
pub use layered_pixels::{LayeredPixels, LayeredPixelsBuilder};
pub use leaf_rule::LeafRule;
pub use multilayer_map::MultilayerMap;
pub use multilayer_settings::{LayeredInfo, Layering, MultilayerSettings};
pub use multilayer_tracer::{MultilayerTracer, TraceSettings, TracedMap};
pub use soft_pcf::{FilteredLayers, SoftPercentageCloser};
pub use store::LayeredKind;
pub use store::bake::{LayeredReport, bake_layers, bake_mtsm};
pub use store::fragments::bake_fragments;
pub use store::reader::LayeredReader;
pub use store::summary::LayeredSummary;
