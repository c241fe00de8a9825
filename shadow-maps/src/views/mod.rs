//! Depth images from several points of a light, through which shadow rays are traced
//! (Agrawala, Ramamoorthi, Heirich & Moll 2000, §5.1).

pub(crate) mod bake;
mod connected;
pub(crate) mod depth_view;
mod in_view;
mod interval;
pub(crate) mod keys;
pub(crate) mod options;
#[cfg(test)]
mod properties;
pub(crate) mod store;
mod trace;
pub(crate) mod tracer;
pub(crate) mod view_tile;
