//! The transmittance of one ray, and the weighted sum of many.

mod compensated;
mod depth_sort;
mod exact_sum;
mod optical_depth;
pub(crate) mod optical_depth_chords;
mod steps;
pub(crate) mod surface_sweep;
pub(crate) mod sweep;
pub(crate) mod transmittance_builder;
pub(crate) mod transmittance_function;
