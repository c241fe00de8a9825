//! Deep OpenEXR files.
//!
//! The `exr` crate knows the headers and the flat codecs but refuses deep
//! pixels. Here are the deep parts, scan lines and tiles, and, through the
//! `exr` crate's codecs, flat images with a depth channel.
//!
//! Sources: *OpenEXR File Layout*, *Interpreting OpenEXR Deep Pixels* (both
//! in the OpenEXR documentation).

mod channels;
mod chunk;
mod codec;
mod deep;
mod error;
mod flat;
mod grid;
mod header;
mod pack;
mod part;
mod read;
mod rows;
mod source;
mod write;
mod write_header;

pub use channels::{AlphaChannels, ExrChannel, ExrChannelType};
pub use error::DeepExrError;
pub use header::{DeepExrHeader, ExrLayout};
pub use part::ExrAttribute;
pub use read::DeepExrReader;
pub use rows::{Alpha, DeepRows, DeepSample};
pub use write_header::{ExportCompression, ExportLayout, ExportSampleType};

pub(crate) use grid::Block;
pub(crate) use write::{ChunkEncoder, DeepExrWriter, PackedChunk};
pub(crate) use write_header::ExportHeader;
