//! Piecewise linear functions of depth: their vertices, one ray's
//! transmittance and the weighted sum of many.

mod compensated;
mod depth_sort;
mod exact_sum;
mod optical_depth;
mod steps;
pub(crate) mod surface_sweep;
pub(crate) mod sweep;
pub(crate) mod transmittance_builder;
pub(crate) mod transmittance_function;
pub(crate) mod vertex;
pub(crate) mod vertex_writer;
