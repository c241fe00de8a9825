//! Multilayer shadow maps for area lights, after Xie, Tabellion & Pearce,
//! *Soft Shadows by Ray Tracing Multilayer Transparent Shadow Maps* (EGSR 2007),
//! and the plain shadow maps that they are compared with.
//!
//! A shadow ray is a straight line in ([raster x, raster y, 1/depth](LightFrame)),
//! and so a map of layers is traced like a scene: [`ShadowRay`] →
//! [`MinMaxPyramid`] → [`walk_pixels`], which hands each pixel that may hold a
//! layer of the ray to a [`PixelLeaf`].
//!
//! [`MultilayerBaker`] makes [`MultilayerMap`]s (§5) and [`MultilayerDepthMap`]s
//! (§4.2). They answer [`dsm_core::VisibilityField`], the former with their
//! first run of layers, so that the filtered lookup of `dsm-core` serves them as
//! it serves a deep shadow map.
//!
//! [`FragmentBuilder`] makes [`FragmentMap`]s, whose layers are planes with
//! coverage masks, and [`FragmentTracer`] traces them: past the paper, closest
//! to tracing the scene itself, and fast.
//!
//! [`DepthMap`] keeps one depth a sample; [`PercentageCloserFilter`] makes soft
//! shadows of it.

mod blocking;
mod build;
mod depth_layers;
mod depth_map;
mod fragments;
mod hash;
mod layer;
mod layered_pixels;
mod leaf_rule;
mod light_frame;
mod multilayer_map;
mod multilayer_settings;
mod multilayer_tracer;
mod pcf;
mod pcf_shadow;
mod pyramid;
mod row_order;
mod run_builder;
mod shadow_ray;
mod soft_pcf;
mod store;
mod strata;
mod tap_region;
mod trace_statistics;
mod walk;

pub use blocking::Blocking;
pub use build::{BakedLayers, MultilayerBaker};
pub use depth_layers::{DepthLayers, MultilayerDepthMap};
pub use depth_map::{DepthMap, DepthMapSettings};
pub use fragments::{
    Fragment, FragmentBuilder, FragmentColumns, FragmentCounts, FragmentMap, FragmentTracer,
    TraceScratch,
};
pub use layer::{Layer, LayerRun};
pub use layered_pixels::{LayeredPixels, LayeredPixelsBuilder};
pub use leaf_rule::LeafRule;
pub use light_frame::LightFrame;
pub use multilayer_map::MultilayerMap;
pub use multilayer_settings::{LayeredInfo, Layering, MultilayerSettings};
pub use multilayer_tracer::{MultilayerTracer, TraceSettings, TracedMap};
pub use pcf::PercentageCloserFilter;
pub use pcf_shadow::PercentageCloserShadow;
pub use pyramid::MinMaxPyramid;
pub use shadow_ray::{RayClip, ShadowRay};
pub use soft_pcf::{FilteredLayers, SoftPercentageCloser};
pub use store::LayeredKind;
pub use store::bake::{LayeredReport, bake_layers, bake_mtsm};
pub use store::fragments::bake_fragments;
pub use store::reader::LayeredReader;
pub use store::summary::LayeredSummary;
pub use trace_statistics::TraceStatistics;
pub use walk::{PixelLeaf, walk_every_pixel, walk_pixels};
