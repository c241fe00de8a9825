//! Media beside fragments: what the ray through each pixel's centre passes, as slabs of
//! constant extinction, and their optical depth along shadow rays.

pub(crate) mod builder;
pub(crate) mod columns;
#[cfg(test)]
mod oracle;
pub(crate) mod tracer;
mod walk;
