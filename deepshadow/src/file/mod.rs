//! Open files.

mod cached_file;
mod open_map;
mod open_options;

pub(crate) use cached_file::CachedFile;
pub(crate) use open_map::OpenMap;
pub use open_options::OpenOptions;
