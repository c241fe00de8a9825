//! Bakes of deep shadow maps (Lokovic & Veach 2000, §3).

pub(crate) mod baker;
pub(crate) mod exact;
mod footprint;
mod ordered;
mod pixel_hits;
pub(crate) mod settings;
pub(crate) mod tile;
