//! Packing and unpacking the bytes of deep chunks.

pub(crate) mod pack;
pub(crate) mod packing;
pub(crate) mod unpack;
pub(crate) mod zstd;
