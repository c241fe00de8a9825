//! Maps of fragments: planes with coverage masks, built from hits and traced
//! for soft shadows.

mod apex;
mod block_hits;
mod builder;
#[cfg(test)]
mod builder_oracle;
#[cfg(test)]
mod colours;
mod columns;
mod cone;
mod far_field;
mod far_table;
mod fold;
mod fragment;
mod frontier;
mod group_occlusion;
mod groups;
mod kernel;
mod lane_count;
mod lanes;
mod large_pages;
mod map;
#[cfg(test)]
mod oracle;
mod packed;
mod packet;
mod range_tree;
#[cfg(test)]
mod receivers;
mod store;
mod surface;
mod tracer;
mod visit_order;

pub use builder::{FragmentBuilder, FragmentCounts};
pub use columns::FragmentColumns;
pub use fragment::Fragment;
pub use map::FragmentMap;
pub use store::{Folded, FragmentKeys, FragmentTile, Fragments, bake_fragments};
pub use tracer::{FragmentTracer, TraceScratch};
