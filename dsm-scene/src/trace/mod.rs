//! All that rays meet, sorted by distance.

mod bvh;
mod medium;
mod met;
mod segment;
mod traced_scene;
mod triangle;

pub(crate) use medium::DensitySample;
pub(crate) use met::MetPlace;
pub(crate) use traced_scene::scaled;
pub use traced_scene::{TracedScene, Tracer};
