//! From pixels to chunks.

use std::ops::Range;

use half::f16;

use super::options::WriteOptions;
use super::sample_type::SampleType;
use crate::channel::{Channel, ChannelType};
use crate::codec::pack::Packer;
use crate::codec::zstd::SampleGrid;
use crate::error::{Error, Result};
use crate::rows::{Alpha, DeepRows};

/// Chunk as a file stores it, without its place.
#[derive(Clone, Debug)]
pub struct EncodedChunk {
    pub(super) size: [u32; 2],
    pub(super) table: Vec<u8>,
    pub(super) samples: Vec<u8>,
    pub(super) unpacked_samples: u64,
    pub(super) max_samples: u32,
}

/// Encoder of blocks of pixels into chunks, with buffers that are kept: one for
/// each thread.
///
/// ```
/// use deep_exr::{DeepExrWriter, DeepSample, Layout, WriteOptions};
/// use deep_exr::detail::ChunkEncoder;
///
/// let options = WriteOptions::new(8, 4).layout(Layout::Tiles { width: 4, height: 4 });
/// let mut writer = DeepExrWriter::new(std::io::Cursor::new(Vec::new()), &options)?;
/// let mut encoder = ChunkEncoder::new(&options);
/// // In any order, from any thread: here from right to left.
/// for column in (0..writer.grid().columns()).rev() {
///     let block = writer.grid().block(column, 0);
///     let mut rows = options.rows(block.width);
///     for _ in 0..block.width * block.height {
///         rows.push(DeepSample { z: 2.0, z_back: 3.0, alpha: [0.25; 3] });
///         rows.finish_pixel()?;
///     }
///     writer.write_chunk(&block, &encoder.encode(&rows)?)?;
/// }
/// writer.finish()?;
/// # Ok::<(), deep_exr::Error>(())
/// ```
pub struct ChunkEncoder {
    options: WriteOptions,
    channels: Vec<Channel>,
    packer: Packer,
    bytes: Vec<u8>,
}

/// The samples of a chunk, unpacked, must be countable in an `i32`.
const MOST_CHUNK_BYTES: u64 = i32::MAX as u64;

impl ChunkEncoder {
    /// An encoder for the chunks of this image.
    #[must_use]
    pub fn new(options: &WriteOptions) -> Self {
        Self {
            channels: options.channels(),
            packer: Packer::new(options.compression.packing()),
            bytes: Vec::new(),
            options: options.clone(),
        }
    }

    /// The chunk of a block: as many rows as it is high, as wide as it is.
    ///
    /// # Errors
    ///
    /// [`Error::Rows`] if the rows don't have the image's columns, or end within
    /// a row; [`Error::LimitExceeded`] for 2 GiB and more of samples.
    pub fn encode(&mut self, rows: &DeepRows) -> Result<EncodedChunk> {
        self.encode_part(rows, 0..rows.width(), 0..rows.rows())
    }

    /// No pixels yet, with the columns of the image.
    pub(super) fn rows(&self, width: u32) -> DeepRows {
        self.options.rows(width)
    }

    /// Why rows cannot be those of the image.
    pub(super) fn misfit(&self, rows: &DeepRows) -> Option<&'static str> {
        if !self.options.fits(rows) {
            Some("the samples do not have the columns of the image")
        } else if !rows.ends_with_a_row() {
            Some("the last row has no end")
        } else {
            None
        }
    }

    /// The chunk of a rectangle within `rows`.
    pub(super) fn encode_part(
        &mut self,
        rows: &DeepRows,
        columns: Range<u32>,
        lines: Range<u32>,
    ) -> Result<EncodedChunk> {
        let size = [columns.len() as u32, lines.len() as u32];
        let place = || format!("{} x {} pixels", size[0], size[1]);
        if let Some(reason) = self.misfit(rows) {
            return Err(Error::Rows { place: place(), reason });
        }
        let width = rows.width() as usize;
        let (first, last) = (columns.start as usize, columns.end as usize);
        let parts = || {
            let line = |y: u32| &rows.offsets()[y as usize * width..];
            lines.clone().map(move |y| &line(y)[first..=last])
        };
        let count: u64 = parts().map(|line| u64::from(line[last - first] - line[0])).sum();
        let words: usize = self.channels.iter().map(|c| c.channel_type.words()).sum();
        let unpacked_samples = 2 * words as u64 * count;
        if unpacked_samples > MOST_CHUNK_BYTES {
            return Err(Error::LimitExceeded {
                place: place(),
                what: "bytes of a chunk",
                value: unpacked_samples,
                limit: MOST_CHUNK_BYTES,
            });
        }
        self.bytes.clear();
        // The table counts up along each row.
        for line in parts() {
            let counts = line[1..].iter().map(|end| end - line[0]);
            self.bytes.extend(counts.flat_map(u32::to_le_bytes));
        }
        let row_width = vec![columns.len() as u32; lines.len()];
        let table_grid = SampleGrid { row_samples: &row_width, channel_words: &[2] };
        let table = self.packer.pack(&self.bytes, &table_grid).to_vec();
        self.bytes.clear();
        for line in parts() {
            let samples = line[0] as usize..line[last - first] as usize;
            for channel in &self.channels {
                append_channel(&mut self.bytes, channel, rows, samples.clone());
            }
        }
        let row_samples: Vec<u32> = parts().map(|line| line[last - first] - line[0]).collect();
        let channel_words: Vec<usize> =
            self.channels.iter().map(|channel| channel.channel_type.words()).collect();
        let grid = SampleGrid { row_samples: &row_samples, channel_words: &channel_words };
        let samples = self.packer.pack(&self.bytes, &grid).to_vec();
        let counts = parts().flat_map(|line| line.windows(2).map(|ends| ends[1] - ends[0]));
        let max_samples = counts.max().unwrap_or(0);
        Ok(EncodedChunk { size, table, samples, unpacked_samples, max_samples })
    }
}

/// Appends the values that a channel has in some samples.
fn append_channel(bytes: &mut Vec<u8>, channel: &Channel, rows: &DeepRows, samples: Range<usize>) {
    let is_half = channel.channel_type == ChannelType::Half;
    let sample_type = if is_half { SampleType::Half } else { SampleType::Float };
    let mut put = |value: f32| {
        if is_half {
            bytes.extend(f16::from_f32(value).to_le_bytes());
        } else {
            bytes.extend(value.to_le_bytes());
        }
    };
    // An opacity below 1 is not stored as one that stops all light.
    let opacity = |value: f32| match value {
        below if below < 1.0 => sample_type.round(below.into()),
        other => other,
    };
    match (channel.name.as_str(), rows.alpha()) {
        ("Z", _) => rows.z()[samples].iter().for_each(|&z| put(z)),
        ("ZBack", _) => {
            rows.z_back().unwrap_or_default()[samples].iter().for_each(|&z| put(z));
        }
        ("A", Alpha::Mono(column))
        | ("AR", Alpha::Colour([column, ..]))
        | ("AG", Alpha::Colour([_, column, _]))
        | ("AB", Alpha::Colour([.., column])) => {
            column[samples].iter().for_each(|&value| put(opacity(value)));
        }
        (_, Alpha::Colour(colours)) => {
            samples.for_each(|index| put(sample_type.round(mean(colours, index))));
        }
        (_, Alpha::Opaque | Alpha::Mono(_)) => samples.for_each(|_| put(1.0)),
    }
}

/// What `A` says where each colour has an opacity of its own.
fn mean(colours: &[Vec<f32>; 3], index: usize) -> f64 {
    colours.iter().map(|column| f64::from(column[index])).sum::<f64>() / 3.0
}
