//! All that rays meet, sorted by distance.

mod bvh;
mod medium;
mod ray;
mod segment;
mod traced_scene;
mod triangle;

pub use ray::Ray;
pub use traced_scene::{TracedScene, Tracer};
