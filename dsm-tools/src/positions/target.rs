//! Shadow factors as a picture, written a band of rows at a time.

use std::io::{Seek, Write};

use anyhow::{Context, Result};
use deepshadow::Values;
use exr::block::writer::ChunksWriter;
use exr::block::{self, BlockIndex, UncompressedBlock};
use exr::meta::BlockDescription;
use exr::meta::attribute::{ChannelDescription, LineOrder, SampleType};
use exr::meta::header::{Header, ImageAttributes, LayerAttributes};
use exr::prelude::{Compression, SmallVec, Text, Vec2};
use rayon::prelude::*;

use super::source::PositionPicture;

/// The header of a picture of factors beside one of positions.
fn header(positions: &PositionPicture, channels: usize) -> Header {
    let names: &[&str] = if channels == 1 { &["Y"] } else { &["B", "G", "R"] };
    let list: SmallVec<[ChannelDescription; 5]> =
        names.iter().map(|&name| ChannelDescription::named(name, SampleType::F32)).collect();
    let [width, height] = positions.size();
    let [x, y] = positions.position();
    Header::new(Text::from("shadow"), Vec2(width, height), list)
        .with_encoding(Compression::ZIP16, BlockDescription::ScanLines, LineOrder::Increasing)
        .with_attributes(LayerAttributes::named("shadow").with_position(Vec2(x, y)))
        .with_shared_attributes(ImageAttributes::new(positions.display_window()))
}

/// Writes a picture of the factors that `factors` gives, some of the next pixels at a time, row by
/// row. Holds these and a row of blocks.
pub(crate) fn write<W: Write + Seek>(
    output: W,
    positions: &PositionPicture,
    channels: usize,
    mut factors: impl FnMut() -> Result<Values>,
) -> Result<()> {
    let header = header(positions, channels);
    let blocks: Vec<(usize, BlockIndex)> =
        block::enumerate_ordered_header_block_indices(std::slice::from_ref(&header)).collect();
    let width = positions.size()[0];
    let mut failed = None;
    let written = block::write(output, SmallVec::from_vec(vec![header]), true, |meta, chunks| {
        let mut pixels = 0;
        let (mut rest, mut left) = (&blocks[..], Band::default());
        while !rest.is_empty() {
            let values = match factors() {
                Ok(values) => values,
                Err(error) => {
                    failed = Some(error);
                    return Err(exr::error::Error::Aborted);
                }
            };
            left.append(&values);
            pixels += values.len();
            let first = pixels / width.max(1);
            if values.is_empty() {
                return Err(exr::error::Error::Aborted);
            }
            // Blocks whose rows are all there.
            let ready = rest
                .iter()
                .take_while(|(_, block)| block.pixel_position.1 + block.pixel_size.1 <= first);
            let (now, later) = rest.split_at(ready.count());
            let packed: exr::error::Result<Vec<_>> = now
                .par_iter()
                .map(|&(index, block)| {
                    let data = left.bytes(&block, channels, width);
                    let block = UncompressedBlock { index: block, data };
                    Ok((index, block.compress_to_chunk(&meta.headers)?))
                })
                .collect();
            for (index, chunk) in packed? {
                chunks.write_chunk(index, chunk)?;
            }
            rest = later;
            let kept = rest.first().map_or(first, |(_, block)| block.pixel_position.1);
            left.drop_rows(kept, width);
        }
        Ok(())
    });
    match failed {
        Some(error) => Err(error),
        None => written.context("encoding the picture"),
    }
}

/// Factors of rows, from some row on.
#[derive(Default)]
struct Band {
    first: usize,
    pixels: Vec<[f32; 3]>,
}

impl Band {
    fn append(&mut self, values: &Values) {
        self.pixels.extend((0..values.len()).map(|point| values.rgb(point)));
    }

    fn drop_rows(&mut self, first: usize, width: usize) {
        self.pixels.drain(..((first - self.first) * width).min(self.pixels.len()));
        self.first = first;
    }

    /// The bytes of a block, row by row, channel by channel.
    fn bytes(&self, block: &BlockIndex, channels: usize, width: usize) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(block.pixel_size.0 * block.pixel_size.1 * channels * 4);
        // In the order of their names: B, G, R.
        let order: &[usize] = if channels == 1 { &[0] } else { &[2, 1, 0] };
        for row in 0..block.pixel_size.1 {
            let start = (block.pixel_position.1 + row - self.first) * width;
            for &channel in order {
                let row = &self.pixels[start..start + width];
                bytes.extend(row.iter().flat_map(|pixel| pixel[channel].to_ne_bytes()));
            }
        }
        bytes
    }
}
