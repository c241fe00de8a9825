//! From columns of samples to the bytes of a file.

pub(crate) mod compression;
pub(crate) mod encoder;
pub(crate) mod options;
mod output_header;
pub(crate) mod sample_type;
pub(crate) mod writer;
