//! Ray tracing: all hits of a ray, sorted by distance.

mod bvh;
mod intersection;
mod medium;
mod segment;
pub(crate) mod traced_scene;
mod triangle;

pub(crate) use intersection::HitGeometry;
pub(crate) use medium::DensitySample;
pub(crate) use traced_scene::scaled;
