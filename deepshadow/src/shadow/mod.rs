//! Shadows of any kind of map, as one type.

mod any_visibility;
mod area_shadow;
mod filtered_shadow;
mod handle;
mod plain;
mod reference;
mod statistics;

pub(crate) use area_shadow::AreaShadow;
pub(crate) use filtered_shadow::filtered_shadow;
pub use handle::Shadow;
pub use plain::{PlainShadow, plain_shadow};
pub use reference::reference_shadow;
pub use statistics::ShadowStatistics;
