//! The mip pyramid of a map (Lokovic & Veach 2000, §5.3), built and written
//! tile by tile.
//!
//! Tiles of level 0 are visited depth first through a quadtree, so that what
//! belongs to one tile of any level comes in one go: each level has at most
//! one tile that is not finished. Within a tile of level 0, all levels down to
//! pixels as large as the largest power of two that divides a tile's width are
//! averaged exactly and compressed once. Pixels larger than that are averages
//! of copies that a small share of the tolerance was spent on, and carry the
//! error of those copies along.
//!
//! Where nothing is, nothing is done: a part of the quadtree without a tile
//! that has vertices is never entered.

pub(crate) mod build;
mod coarse;
mod fragment;
mod open_tiles;
pub(crate) mod plan;
pub(crate) mod source;
pub(crate) mod stored;
mod tile_levels;
mod traversal;
