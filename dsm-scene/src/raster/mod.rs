//! Hits of a shadow camera's own rays by micro-rasterisation.
//!
//! Rays of one camera need no tree: a primitive's outline in the map says which
//! pixels it can cover. There, all samples of a pixel are tested at once, each
//! with its exact ray. A block of pixels goes through these steps:
//! [`layer`] (primitives of one kind, with the [`bins`] that find those near a
//! block) → [`outline`] (rows of cells that each can cover) → [`cell_lists`]
//! (cell by cell) → [`kernel`] (16 rays at a time) → [`cell_hits`]. [`dispatched`]
//! holds the code that is compiled for each level of instructions.
//!
//! Everything is computed from the map's pixel and the primitive alone, and in
//! one order, so that neither blocks nor threads nor processors show in a map.
//! The kernel fuses multiplications and additions on every processor.

mod bins;
mod cell_hits;
mod cell_lists;
mod cells;
mod corner;
mod dispatched;
mod fused;
mod kernel;
mod layer;
mod outline;
mod primitive;
pub(crate) mod rasterizer;
mod rays;
pub(crate) mod scene_rasterizer;
pub(crate) mod segment;
mod triangle;

#[cfg(test)]
mod oracle;
#[cfg(test)]
mod tests;
