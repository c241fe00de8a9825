//! Layered attenuation maps: the places that any point of a light sees, each with the
//! share of the light that it sees (Agrawala, Ramamoorthi, Heirich & Moll 2000, §4).

pub(crate) mod bake;
pub(crate) mod builder;
pub(crate) mod cached;
mod image;
pub(crate) mod keys;
pub(crate) mod map;
#[cfg(test)]
mod oracle;
#[cfg(test)]
mod properties;
pub(crate) mod shadow;
mod side;
pub(crate) mod source;
pub(crate) mod store;
mod view;
mod warp;
