//! Shadows of any kind of map, as one type.

mod any_visibility;
mod area_shadow;
mod filtered_shadow;
pub(crate) mod handle;
pub(crate) mod plain;
pub(crate) mod reference;
pub(crate) mod statistics;

pub(crate) use area_shadow::AreaShadow;
pub(crate) use filtered_shadow::filtered_shadow;
