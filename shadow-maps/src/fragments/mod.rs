//! Maps of fragments: planes with coverage masks, built from hits and traced
//! for soft shadows.

mod apex;
mod block_hits;
pub(crate) mod builder;
#[cfg(test)]
mod builder_oracle;
#[cfg(test)]
mod colours;
pub(crate) mod columns;
mod cone;
mod far_field;
mod far_table;
mod fold;
pub(crate) mod fragment;
mod frontier;
mod group_occlusion;
mod groups;
mod kernel;
mod lane_count;
mod lanes;
mod large_pages;
pub(crate) mod map;
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
pub(crate) mod tracer;
mod trial;
mod visit_order;
