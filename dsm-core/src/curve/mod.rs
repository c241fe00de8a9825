//! Piecewise linear functions of depth: their vertices, one ray's
//! transmittance and the weighted sum of many.

pub(crate) mod vertex;
