//! Filtered shadow lookups: what is asked, around which point, and the
//! average over the pixels there, in one level or between two.

mod block;
pub(crate) mod field;
pub(crate) mod filtered;
pub(crate) mod footprint;
pub(crate) mod projection;
pub(crate) mod pyramid;
pub(crate) mod receiver;
pub(crate) mod shadow;
mod weights;
