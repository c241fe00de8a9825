//! Pictures of a scene under one light, with any shadow method.

pub(crate) mod image;
mod interaction;
pub(crate) mod png;
pub(crate) mod renderer;
mod sampler;
mod shading;
