//! Hits of rays, and the sample points that rays start at.

pub(crate) mod hit;
pub(crate) mod hit_source;
pub(crate) mod sampling;
pub(crate) mod tile_hits;
pub(crate) mod tile_samples;
