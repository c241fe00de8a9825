//! What the commands write.

pub(crate) mod light;
pub(crate) mod plot;
pub(crate) mod slice;
pub(crate) mod summary;
