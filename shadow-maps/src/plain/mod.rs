//! Plain shadow maps, and percentage closer filtering of them (Reeves, Salesin
//! & Cook, *Rendering Antialiased Shadows with Depth Maps*, SIGGRAPH 1987).
//!
//! [`DepthMap`] keeps the depths of each pixel's samples;
//! [`PercentageCloserFilter`] compares them with a receiver's.

pub(crate) mod blocking;
mod depth_map;
mod pcf;
pub(crate) mod shadow;
mod strata;
mod tap_region;

pub use depth_map::{DepthMap, DepthMapSettings};
pub use pcf::PercentageCloserFilter;
