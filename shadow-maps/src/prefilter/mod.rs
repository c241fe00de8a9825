//! Prefiltered multilayer maps: lists of fragments, merged by wider and wider filters,
//! for soft shadows by lookup (Selgrad et al. 2014).

pub(crate) mod accumulate;
pub(crate) mod bake;
pub(crate) mod builder;
pub(crate) mod cached;
pub(crate) mod epsilon;
mod hat;
pub(crate) mod hybrid;
pub(crate) mod keys;
pub(crate) mod level_plan;
pub(crate) mod light_parts;
mod list_sum;
pub(crate) mod lists;
mod lookup;
pub(crate) mod map;
pub(crate) mod merge;
#[cfg(test)]
mod oracle;
mod own_plane;
#[cfg(test)]
mod properties;
mod pyramid;
pub(crate) mod settings;
pub(crate) mod shadow;
mod source;
pub(crate) mod store;
mod sums;
pub(crate) mod tile;
