//! Writing deep images, chunk by chunk.

use std::path::Path;

use half::f16;

use super::channels::ExrChannelType;
use super::grid::Block;
use super::pack::Packer;
use super::rows::{Alpha, DeepRows};
use super::write_header::{ExportCompression, ExportHeader, ExportSampleType};
use crate::Result;
use crate::format::atomic_file::AtomicFile;

/// A chunk as it is stored, without its place.
pub(crate) struct PackedChunk {
    table: Vec<u8>,
    samples: Vec<u8>,
    unpacked_samples: u64,
    max_samples: u32,
}

/// Turns pixels into chunks, in buffers that are kept.
pub(crate) struct ChunkEncoder {
    sample_type: ExportSampleType,
    packer: Packer,
    bytes: Vec<u8>,
}

/// The samples of a chunk, unpacked, must be countable in an `i32`.
const MOST_CHUNK_BYTES: u64 = i32::MAX as u64;

impl ChunkEncoder {
    pub(crate) fn new(sample_type: ExportSampleType, compression: ExportCompression) -> Self {
        Self { sample_type, packer: Packer::new(compression.packing()), bytes: Vec::new() }
    }

    /// The chunk of these whole pixel rows.
    pub(crate) fn encode(&mut self, header: &ExportHeader, rows: &DeepRows) -> Result<PackedChunk> {
        let words: usize = header.channels().iter().map(|c| c.channel_type.words()).sum();
        let unpacked_samples = 2 * words as u64 * rows.sample_count() as u64;
        crate::error::check_limit("bytes of a chunk", unpacked_samples, MOST_CHUNK_BYTES)?;
        let width = rows.width() as usize;
        let lines = || rows.offsets().windows(width + 1).step_by(width);
        self.bytes.clear();
        // The table counts up along each row.
        for line in lines() {
            let counts = line[1..].iter().map(|end| end - line[0]);
            self.bytes.extend(counts.flat_map(u32::to_le_bytes));
        }
        let table = self.packer.pack(&self.bytes).to_vec();
        self.bytes.clear();
        for line in lines() {
            let samples = line[0] as usize..line[width] as usize;
            for channel in header.channels() {
                let mut put = |value: f32| match channel.channel_type {
                    ExrChannelType::Half => self.bytes.extend(f16::from_f32(value).to_le_bytes()),
                    _ => self.bytes.extend(value.to_le_bytes()),
                };
                match (stored_column(rows, &channel.name), rows.alpha()) {
                    (Some(column), _) => column[samples.clone()].iter().for_each(|&v| put(v)),
                    (None, Alpha::Colour(colours)) => samples
                        .clone()
                        .for_each(|index| put(self.sample_type.round(mean(colours, index)))),
                    (None, _) => samples.clone().for_each(|_| put(1.0)),
                }
            }
        }
        let samples = self.packer.pack(&self.bytes).to_vec();
        let counts = rows.offsets().windows(2).map(|ends| ends[1] - ends[0]);
        Ok(PackedChunk { table, samples, unpacked_samples, max_samples: counts.max().unwrap_or(0) })
    }
}

/// The column that is stored as it is.
fn stored_column<'a>(rows: &'a DeepRows, name: &str) -> Option<&'a [f32]> {
    match (name, rows.alpha()) {
        ("Z", _) => Some(rows.z()),
        ("ZBack", _) => rows.z_back(),
        ("A", Alpha::Mono(column))
        | ("AR", Alpha::Colour([column, ..]))
        | ("AG", Alpha::Colour([_, column, _]))
        | ("AB", Alpha::Colour([.., column])) => Some(column),
        _ => None,
    }
}

/// What `A` says where each colour has an opacity of its own.
fn mean(colours: &[Vec<f32>; 3], index: usize) -> f64 {
    colours.iter().map(|column| f64::from(column[index])).sum::<f64>() / 3.0
}

/// Writes a deep image of one part. The file appears when it is finished;
/// dropped before, it leaves no trace.
pub(crate) struct DeepExrWriter<'a> {
    file: AtomicFile,
    header: &'a ExportHeader,
    offsets: Vec<u64>,
    max_samples: u32,
}

impl<'a> DeepExrWriter<'a> {
    /// Starts a file that will replace `path`, which may not exist yet.
    pub(crate) fn create(path: &Path, header: &'a ExportHeader) -> Result<Self> {
        let offsets = vec![0; usize::try_from(header.grid().count()).unwrap_or(usize::MAX)];
        let mut writer = Self { file: AtomicFile::create(path)?, header, offsets, max_samples: 0 };
        // The fullest pixel and the chunks' places are known at the end.
        let start = writer.start();
        writer.in_file(|file| file.append(&start))?;
        Ok(writer)
    }

    /// Header and offset table.
    fn start(&self) -> Vec<u8> {
        let mut bytes = self.header.bytes(self.max_samples);
        bytes.extend(self.offsets.iter().flat_map(|offset| offset.to_le_bytes()));
        bytes
    }

    fn in_file(&mut self, write: impl FnOnce(&mut AtomicFile) -> Result<()>) -> Result<()> {
        let Self { file, .. } = self;
        write(file).map_err(|error| error.in_file(Some(file.path())))
    }

    /// Appends the chunk of a block.
    pub(crate) fn write(&mut self, block: &Block, chunk: &PackedChunk) -> Result<()> {
        let PackedChunk { table, samples, unpacked_samples, max_samples } = chunk;
        let (coordinates, count) = self.header.grid().coordinates(block);
        let mut start: Vec<u8> =
            coordinates[..count].iter().flat_map(|number| number.to_le_bytes()).collect();
        for size in [table.len() as u64, samples.len() as u64, *unpacked_samples] {
            start.extend(size.to_le_bytes());
        }
        self.offsets[self.header.grid().index(block)] = self.file.length();
        self.max_samples = self.max_samples.max(*max_samples);
        self.in_file(|file| {
            [&start, table, samples].iter().try_for_each(|bytes| file.append(bytes))
        })
    }

    /// Puts the file in its place. Returns the number of samples of the
    /// fullest pixel.
    pub(crate) fn finish(self) -> Result<u32> {
        let start = self.start();
        let path = self.file.path().to_owned();
        self.file.commit(&start).map_err(|error| error.in_file(Some(&path)))?;
        Ok(self.max_samples)
    }
}
