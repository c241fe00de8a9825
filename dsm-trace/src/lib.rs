//! Shadow rays through depth images, whatever each pixel holds.
//!
//! Seen from a light, a shadow ray is a straight line in
//! (raster x, raster y, 1/depth), so that a map is traced like a
//! scene: [`ShadowRay`] → [`MinMaxPyramid`] → [`walk_pixels`], which hands each
//! pixel that may hold an occluder of the ray to a visitor (Xie,
//! Tabellion & Pearce, *Soft Shadows by Ray Tracing Multilayer Transparent
//! Shadow Maps*, EGSR 2007, §4.3 and §6.1).

mod coherence;
mod cut_layers;
mod layering;
mod light_frame;
mod light_mean;
mod min_max_builder;
mod min_max_pyramid;
mod range_blocks;
mod shadow_ray;
mod statistics;
mod walk;

pub use min_max_pyramid::MinMaxPyramid;
pub use shadow_ray::ShadowRay;
pub use walk::walk_pixels;

/// Parts that the other crates of this family stand on. They may change with any
/// version.
#[doc(hidden)]
pub mod detail {
    pub use crate::{
        coherence::{
            coherent_shadow::CoherentShadow,
            settings::{CoherenceSettings, MOST_CELLS},
            statistics::CoherenceStatistics,
        },
        cut_layers::{CutLayers, CutSum},
        layering::Layering,
        light_frame::LightFrame,
        light_mean::LightMean,
        min_max_builder::MinMaxBuilder,
        shadow_ray::RayClip,
        statistics::{TraceCounters, TraceStatistics},
        walk::{PixelLeaf, walk_every_pixel},
    };
}
