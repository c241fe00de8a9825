//! Maps in files.

mod cached_file;
mod open_map;
mod open_options;
mod shadow_map;

pub(crate) use cached_file::CachedFile;
pub(crate) use open_map::OpenMap;
pub use open_options::OpenOptions;
pub use shadow_map::ShadowMap;
