//! Decoding flat chunks, where every pixel is one sample. The `exr` crate
//! unpacks them.

use exr::math::Vec2;
use exr::meta::attribute::IntegerBounds;
use half::f16;

use super::chunk::{ChunkPlace, ChunkStart};
use super::decoder::Decoder;
use crate::channel::ChannelType;
use crate::error::Result;
use crate::grid::Block;
use crate::rows::DeepRows;

impl Decoder {
    /// Appends the pixel rows of one row of blocks.
    pub(super) fn append_flat_band(&mut self, band: u32, out: &mut DeepRows) -> Result<()> {
        let grid = self.part.grid;
        let chunks: Vec<_> = (0..grid.columns())
            .map(|column| self.flat_chunk(grid.block(column, band)))
            .collect::<Result<_, _>>()?;
        let first = out.pixel_count();
        let pixels = grid.rows(band).len() * grid.width() as usize;
        self.check_answer(out, pixels, pixels as u64)?;
        out.add_pixels(pixels).fill(1);
        out.add_counted_samples(first)?;
        for chunk in &chunks {
            self.read_pixels(chunk, first, out)?;
        }
        Ok(())
    }

    fn flat_chunk(&mut self, block: Block) -> Result<(Block, ChunkStart, u64)> {
        let start = self.table.locate(&mut self.source, &self.part, &block)?;
        let place = ChunkPlace { part: &self.part, block: &block, offset: start.offset };
        let left = self.source.length() - start.data_offset;
        if left < 4 {
            return Err(place.error("cut off by the end of the file"));
        }
        let size = self.source.slice(start.data_offset, 4, "chunk size")?;
        let size = i32::from_le_bytes([size[0], size[1], size[2], size[3]]);
        let packed = u64::try_from(size).ok().filter(|&packed| packed <= left - 4);
        let packed =
            packed.ok_or_else(|| place.error(format!("size {size}, the file has {left} more")))?;
        let unpacked = self.part.plan.bytes_per_sample() * block.pixels();
        place.check_size("packed pixels in bytes", packed, &self.limits)?;
        place.check_size("pixels in bytes", unpacked, &self.limits)?;
        if unpacked > packed.saturating_mul(self.part.packing.expansion()) {
            return Err(place.error(format!("{packed} bytes cannot stand for {unpacked}")));
        }
        Ok((block, start, packed))
    }

    fn read_pixels(
        &mut self,
        (block, start, packed): &(Block, ChunkStart, u64),
        first_pixel: usize,
        out: &mut DeepRows,
    ) -> Result<()> {
        let Decoder { source, part, .. } = self;
        let place = ChunkPlace { part, block, offset: start.offset };
        let Some(header) = &part.flat else {
            return Err(place.error("the part is not flat"));
        };
        let packed = source.slice(start.data_offset + 4, *packed, "pixels")?.to_vec();
        let [x, y] = part.header.data_window.min;
        let section = IntegerBounds {
            position: Vec2(x + block.x as i32, y + block.y as i32),
            size: Vec2(block.width as usize, block.height as usize),
        };
        let bytes = header
            .compression
            .decompress_image_section_from_le(header, packed, section, false)
            .map_err(|error| place.error(error.to_string()))?;
        let width = block.width as usize;
        let row_bytes = width * part.plan.bytes_per_sample() as usize;
        if bytes.len() != row_bytes * block.height as usize {
            return Err(place.error(format!("unpacks to {} bytes", bytes.len())));
        }
        for (row, bytes) in bytes.chunks_exact(row_bytes).enumerate() {
            let pixel = first_pixel + row * part.grid.width() as usize + block.x as usize;
            let target = out.pixel(pixel).start..out.pixel(pixel + width - 1).end;
            for source in part.plan.sources() {
                let start = 2 * width * source.words_before;
                let values = &bytes[start..start + 2 * width * source.channel_type.words()];
                if let Some(column) = out.column_mut(source.column) {
                    convert(source.channel_type, values, &mut column[target.clone()]);
                }
            }
        }
        Ok(())
    }
}

/// The `exr` crate answers in the machine's byte order.
fn convert(channel_type: ChannelType, bytes: &[u8], values: &mut [f32]) {
    let halves = bytes.as_chunks::<2>().0.iter().copied();
    let longs = bytes.as_chunks::<4>().0.iter().copied();
    match channel_type {
        ChannelType::Half => {
            values.iter_mut().zip(halves).for_each(|(v, b)| *v = f16::from_ne_bytes(b).to_f32());
        }
        ChannelType::Float => {
            values.iter_mut().zip(longs).for_each(|(v, b)| *v = f32::from_ne_bytes(b));
        }
        ChannelType::Uint => {
            values.iter_mut().zip(longs).for_each(|(v, b)| *v = u32::from_ne_bytes(b) as f32);
        }
    }
}
