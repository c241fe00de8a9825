//! Compression to the fewest vertices.

pub(crate) mod compressor;
mod hull;
mod joint;
mod link;
mod rounding;
mod rungs;
mod shorten;
mod walk;
