//! Maps of fragments: planes with coverage masks, built from hits and traced
//! for soft shadows.

mod apex;
pub(crate) mod bake;
mod baked_tile;
mod block_hits;
pub(crate) mod builder;
#[cfg(test)]
mod builder_oracle;
#[cfg(test)]
mod colours;
pub(crate) mod columns;
mod cone;
mod exponential;
mod far_field;
mod far_table;
mod fold;
pub(crate) mod fragment;
mod frontier;
mod group_occlusion;
mod groups;
mod kernel;
pub(crate) mod keys;
mod lane_count;
mod lanes;
mod large_pages;
pub(crate) mod map;
pub(crate) mod media;
mod near_planes;
#[cfg(test)]
pub(crate) mod oracle;
mod packed;
mod packet;
mod range_tree;
#[cfg(test)]
mod receivers;
pub(crate) mod store;
mod surface;
pub(crate) mod tile;
pub(crate) mod tracer;
mod trial;
mod visit_order;
