//! Fields of visibility functions: maps in memory, and lookups in them.

pub(crate) mod bias;
mod block;
pub(crate) mod filtered;
pub(crate) mod filtered_shadow;
pub(crate) mod footprint;
pub(crate) mod map;
pub(crate) mod pixel_lists;
pub(crate) mod pyramid;
pub(crate) mod receiver;
pub(crate) mod shadow;
pub(crate) mod visibility_field;
mod weights;
