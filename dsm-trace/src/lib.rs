//! Shadow rays through depth images, whatever each pixel holds.
//!
//! Seen from a light, a shadow ray is a straight line in
//! ([raster x, raster y, 1/depth](LightFrame)), so that a map is traced like a
//! scene: [`ShadowRay`] → [`MinMaxPyramid`] → [`walk_pixels`], which hands each
//! pixel that may hold an occluder of the ray to a [`PixelLeaf`] (Xie,
//! Tabellion & Pearce, *Soft Shadows by Ray Tracing Multilayer Transparent
//! Shadow Maps*, EGSR 2007, §4.3 and §6.1). [`LightMean`] averages rays over the
//! samples of an area light.

mod light_frame;
mod light_mean;
mod min_max_pyramid;
mod shadow_ray;
mod statistics;
mod walk;

pub use light_frame::LightFrame;
pub use light_mean::LightMean;
pub use min_max_pyramid::MinMaxPyramid;
pub use shadow_ray::{RayClip, ShadowRay};
pub use statistics::{TraceCounters, TraceStatistics};
pub use walk::{PixelLeaf, walk_every_pixel, walk_pixels};
