//! Deep OpenEXR images in pure Rust, read and written.
//!
//! A deep image has any number of samples a pixel, each with a depth, mostly
//! with a back, and an opacity. [`DeepExrReader`] reads them some rows at a
//! time into columns ([`DeepRows`]), from scan lines and tiles, one part of
//! many, NONE, RLE and ZIPS; flat images with a channel `Z` come the same way,
//! one sample a pixel. [`DeepExrWriter`] writes such rows to anything that can
//! seek, and [`ChunkEncoder`](detail::ChunkEncoder) packs chunks on several threads.
//!
//! Files may come from strangers: every size is held against the file and
//! [`Limits`] before memory is taken, and whatever is damaged is an [`Error`]
//! that says where. No `unsafe` code.
//!
//! ```
//! use deep_exr::{DeepExrReader, DeepExrWriter, DeepRows, Limits, WriteOptions};
//!
//! # fn image() -> Result<Vec<u8>, deep_exr::Error> {
//! #     let options = WriteOptions::new(2, 1);
//! #     let mut rows = options.rows(2);
//! #     for z in [1.0, 3.0] {
//! #         rows.push(deep_exr::DeepSample { z, z_back: z, alpha: [0.5; 3] });
//! #         rows.finish_pixel()?;
//! #     }
//! #     let mut writer = DeepExrWriter::new(std::io::Cursor::new(Vec::new()), &options)?;
//! #     writer.write_rows(&rows)?;
//! #     Ok(writer.finish()?.into_inner())
//! # }
//! # let bytes = image()?;
//! // What lies nearer than 2 goes, the rest stays as it is.
//! let mut reader = DeepExrReader::from_bytes(bytes, None, &Limits::default())?;
//! let options = WriteOptions::like(reader.header());
//! let output = std::io::Cursor::new(Vec::new());
//! let mut writer = DeepExrWriter::new(output, &options)?;
//! for y in 0..reader.header().height {
//!     let row = reader.read_rows(y..y + 1)?;
//!     let mut kept = options.rows(row.width());
//!     for pixel in 0..row.pixel_count() {
//!         let samples = row.pixel(pixel).map(|index| row.sample(index));
//!         samples.filter(|sample| sample.z >= 2.0).for_each(|sample| kept.push(sample));
//!         kept.finish_pixel()?;
//!     }
//!     writer.write_rows(&kept)?;
//! }
//! assert_eq!(writer.max_samples(), 1);
//! writer.finish()?;
//! # Ok::<(), deep_exr::Error>(())
//! ```
//!
//! The `exr` crate knows headers and the flat codecs and refuses deep pixels:
//! its value types and codecs are used, the deep part is here. Sources: *OpenEXR
//! File Layout*, *Interpreting OpenEXR Deep Pixels* (both in the OpenEXR
//! documentation).

mod attribute;
mod channel;
mod codec;
mod error;
mod grid;
mod layout;
mod limits;
mod read;
mod rows;
mod sample;
mod selection;
mod window;
mod write;

pub use attribute::Attribute;
pub use channel::{AlphaChannels, Channel, ChannelType};
pub use error::Error;
pub use layout::Layout;
pub use limits::Limits;
pub use read::{header::Header, reader::DeepExrReader};
pub use rows::DeepRows;
pub use sample::DeepSample;
pub use selection::Selection;
pub use window::Window;
pub use write::{compression::Compression, sample_type::SampleType};
pub use write::{options::WriteOptions, writer::DeepExrWriter};

/// Parts that the other crates of this family stand on. They may change with any
/// version.
#[doc(hidden)]
pub mod detail {
    pub use crate::{
        channel::ReadChannels,
        error::Result,
        grid::{Block, ChunkGrid},
        rows::Alpha,
        selection::ChannelNames,
        write::encoder::{ChunkEncoder, EncodedChunk},
    };
}
