//! Open files.

mod cached_file;
mod open_map;
pub(crate) mod open_options;
pub(crate) mod texel_hits;

pub(crate) use cached_file::CachedFile;
pub(crate) use open_map::{AnyTracer, Near, OpenMap};
