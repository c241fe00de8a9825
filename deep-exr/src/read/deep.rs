//! Decoding deep chunks: a table of sample counts, then the samples.

use half::f16;
use half::slice::{HalfBitsSliceExt, HalfFloatSliceExt};

use super::chunk::{ChunkPlace, DeepChunk};
use super::decoder::Decoder;
use super::plan::ColumnSource;
use crate::channel::ChannelType;
use crate::codec::zstd::SampleGrid;
use crate::error::Result;
use crate::grid::Block;
use crate::rows::DeepRows;

impl Decoder {
    /// Appends the pixel rows of one row of blocks.
    pub(super) fn append_deep_band(&mut self, band: u32, out: &mut DeepRows) -> Result<()> {
        let grid = self.part.grid;
        let mut chunks = std::mem::take(&mut self.chunks);
        chunks.clear();
        for column in 0..grid.columns() {
            chunks.push(self.deep_chunk(grid.block(column, band))?);
        }
        // All sizes are known to be possible: take memory now.
        let first = out.pixel_count();
        let width = grid.width() as usize;
        let pixels = grid.rows(band).len() * width;
        self.check_answer(out, pixels, 0)?;
        let counts = out.add_pixels(pixels);
        let mut samples = 0;
        for chunk in &chunks {
            samples += self.read_counts(chunk, width, counts)?;
        }
        self.check_answer(out, 0, samples)?;
        out.add_counted_samples(first)?;
        for chunk in &chunks {
            self.read_samples(chunk, first, out)?;
        }
        self.chunks = chunks;
        Ok(())
    }

    /// Reads the sizes at the head of a chunk, and compares them with the
    /// file and the limits.
    fn deep_chunk(&mut self, block: Block) -> Result<DeepChunk> {
        let start = self.table.locate(&mut self.source, &self.part, &block)?;
        let place = ChunkPlace { part: &self.part, block: &block, offset: start.offset };
        let file_length = self.source.length();
        if file_length - start.data_offset < 24 {
            return Err(place.error("cut off by the end of the file"));
        }
        let sizes = self.source.slice(start.data_offset, 24, "chunk sizes")?.as_chunks::<8>().0;
        let [packed_table, packed_samples, unpacked_samples] =
            [0, 1, 2].map(|i| u64::from_le_bytes(sizes[i]));
        let table_offset = start.data_offset + 24;
        let left = file_length - table_offset;
        if packed_table > left || packed_samples > left - packed_table {
            return Err(place.error(format!(
                "needs {packed_table} + {packed_samples} bytes, the file has {left} more"
            )));
        }
        let table = 4 * block.pixels();
        for (what, bytes) in [
            ("packed sample table in bytes", packed_table),
            ("packed samples in bytes", packed_samples),
            ("sample table in bytes", table),
            ("samples in bytes", unpacked_samples),
        ] {
            place.check_size(what, bytes, &self.limits)?;
        }
        let expansion = self.part.packing.expansion();
        for (packed, unpacked) in [(packed_table, table), (packed_samples, unpacked_samples)] {
            if unpacked > packed.saturating_mul(expansion) {
                return Err(place.error(format!("{packed} bytes cannot stand for {unpacked}")));
            }
        }
        let sample = self.part.plan.bytes_per_sample();
        if !unpacked_samples.is_multiple_of(sample) {
            return Err(place.error(format!(
                "{unpacked_samples} bytes are no whole number of samples of {sample} bytes"
            )));
        }
        Ok(DeepChunk {
            block,
            offset: start.offset,
            table_offset,
            packed_table,
            packed_samples,
            unpacked_samples,
        })
    }

    /// Writes the block's sample counts into those of its band, and returns
    /// their sum. The table counts up along each row.
    fn read_counts(
        &mut self,
        chunk: &DeepChunk,
        band_width: usize,
        counts: &mut [u32],
    ) -> Result<u64> {
        let Decoder { source, part, unpacker, limits, .. } = self;
        let block = &chunk.block;
        let place = ChunkPlace { part, block, offset: chunk.offset };
        let width = block.width as usize;
        let [whole_width, whole_height] = part.grid.whole_block().map(u64::from);
        let size = 4 * width * block.height as usize;
        let whole_size = (4 * whole_width * whole_height).min(limits.max_chunk_bytes & !3);
        let packed = source.slice(chunk.table_offset, chunk.packed_table, "sample table")?;
        let row_width = vec![block.width; block.height as usize];
        let grid = SampleGrid { row_samples: &row_width, channel_words: &[2] };
        let words = unpacker
            .unpack(part.packing, packed, size, (whole_size as usize).max(size), &grid)
            .map_err(|reason| place.error(format!("sample table: {reason}")))?;
        let (entries, _) = words.as_chunks::<2>();
        let mut samples = 0_u64;
        let band_rows = counts.chunks_exact_mut(band_width);
        for (row, (entries, counts)) in entries.chunks_exact(width).zip(band_rows).enumerate() {
            let x = block.x as usize;
            let mut before = 0;
            for (column, (entry, count)) in
                entries.iter().zip(&mut counts[x..x + width]).enumerate()
            {
                let end = u32::from(entry[0]) | u32::from(entry[1]) << 16;
                *count = end.wrapping_sub(before);
                if end < before || *count > limits.max_samples_per_pixel {
                    return Err(place.error(format!(
                        "sample table: entry {end} after {before}, at column {column} of row {row} \
                         (at most {} samples a pixel are allowed)",
                        limits.max_samples_per_pixel
                    )));
                }
                before = end;
            }
            samples += u64::from(before);
        }
        let stated = chunk.unpacked_samples / part.plan.bytes_per_sample();
        if samples != stated {
            return Err(place.error(format!("{samples} samples counted, room for {stated}")));
        }
        Ok(samples)
    }

    /// Fills the columns: samples stand row by row, then channel by channel.
    fn read_samples(
        &mut self,
        chunk: &DeepChunk,
        first_pixel: usize,
        out: &mut DeepRows,
    ) -> Result<()> {
        if chunk.unpacked_samples == 0 {
            return Ok(());
        }
        let Decoder { source, part, unpacker, .. } = self;
        let block = &chunk.block;
        let place = ChunkPlace { part, block, offset: chunk.offset };
        let packed = source.slice(
            chunk.table_offset + chunk.packed_table,
            chunk.packed_samples,
            "samples",
        )?;
        let size = chunk.unpacked_samples as usize;
        let row_samples: Vec<u32> = (0..block.height as usize)
            .map(|row| {
                let pixel = first_pixel + row * part.grid.width() as usize + block.x as usize;
                let last = out.pixel(pixel + block.width as usize - 1);
                (last.end - out.pixel(pixel).start) as u32
            })
            .collect();
        let grid =
            SampleGrid { row_samples: &row_samples, channel_words: part.plan.channel_words() };
        let words = unpacker
            .unpack(part.packing, packed, size, size, &grid)
            .map_err(|reason| place.error(format!("samples: {reason}")))?;
        let mut row_start = 0;
        for row in 0..block.height as usize {
            let pixel = first_pixel + row * part.grid.width() as usize + block.x as usize;
            let target = out.pixel(pixel).start..out.pixel(pixel + block.width as usize - 1).end;
            let samples = target.len();
            for source in part.plan.sources() {
                let start = row_start + samples * source.words_before;
                let values = &words[start..start + samples * source.channel_type.words()];
                if let Some(column) = out.column_mut(source.column) {
                    convert(source, values, &mut column[target.clone()]);
                }
            }
            row_start += samples * part.plan.words_per_sample();
        }
        Ok(())
    }
}

fn convert(source: &ColumnSource, words: &[u16], values: &mut [f32]) {
    let long = |pair: [u16; 2]| u32::from(pair[0]) | u32::from(pair[1]) << 16;
    let pairs = words.as_chunks::<2>().0.iter().zip(values.iter_mut());
    match source.channel_type {
        ChannelType::Half => words.reinterpret_cast::<f16>().convert_to_f32_slice(values),
        ChannelType::Float => pairs.for_each(|(&pair, v)| *v = f32::from_bits(long(pair))),
        ChannelType::Uint => pairs.for_each(|(&pair, v)| *v = long(pair) as f32),
    }
}
