//! Multilayer maps in `.dsm` files: the kinds `mtsm` and `layers`, as
//! `docs/format/dsm-1.md`, section 13, defines them.

pub(crate) mod bake;
pub(crate) mod keys;
pub(crate) mod layers;
pub(crate) mod mtsm;
mod tile;
