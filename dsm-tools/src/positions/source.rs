//! Positions of a picture, a band of rows at a time, whatever blocks they are stored in.

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use deepshadow::glam::DVec3;
use exr::block::chunk::Chunk;
use exr::block::reader::{ChunksReader, Reader};
use exr::block::{self, UncompressedBlock};
use exr::meta::BlockDescription;
use exr::meta::attribute::{IntegerBounds, SampleType};
use exr::meta::header::Header;
use exr::prelude::f16;
use rayon::prelude::*;

use super::channels::position_part;

/// Pixels of a band, about.
const BAND_PIXELS: usize = 1 << 20;
/// The most pixels of a picture: 2³².
const MOST_PIXELS: u64 = 1 << 32;

/// A picture of positions.
pub(crate) struct PositionPicture {
    path: PathBuf,
    part: usize,
    channels: [usize; 3],
    header: Header,
    /// Rows of a band, a multiple of the height of its blocks.
    band: usize,
}

impl PositionPicture {
    /// Reads the header.
    pub(crate) fn open(path: &Path) -> Result<Self> {
        let reader = reader(path)?;
        let (part, channels) = position_part(reader.headers())?;
        let header = reader.headers()[part].clone();
        let (width, height) = (header.layer_size.0, header.layer_size.1);
        let pixels = width as u64 * height as u64;
        ensure!(pixels <= MOST_PIXELS, "it has {width} × {height} pixels, more than 2³²");
        ensure!(
            header
                .channels
                .list
                .iter()
                .all(|channel| (channel.sampling.0, channel.sampling.1) == (1, 1)),
            "some of its channels have less than one sample a pixel"
        );
        let block = match header.blocks {
            BlockDescription::ScanLines => header.compression.scan_lines_per_block(),
            BlockDescription::Tiles(tiles) => tiles.tile_size.1,
        };
        let band = (BAND_PIXELS / width.max(1)).max(1).next_multiple_of(block.max(1));
        Ok(Self { path: path.to_owned(), part, channels, header, band })
    }

    /// Width and height in pixels.
    pub(crate) fn size(&self) -> [usize; 2] {
        [self.header.layer_size.0, self.header.layer_size.1]
    }

    /// The first row and column of the data window.
    pub(crate) fn position(&self) -> [i32; 2] {
        let corner = self.header.own_attributes.layer_position;
        [corner.0, corner.1]
    }

    /// The display window.
    pub(crate) fn display_window(&self) -> IntegerBounds {
        self.header.shared_attributes.display_window
    }

    /// Rows of a band.
    pub(crate) const fn band(&self) -> usize {
        self.band
    }

    /// The positions of the rows from `first` on, up to a band of them, row by row. Blocks are
    /// unpacked in parallel. Memory: that of a band, packed and unpacked.
    pub(crate) fn read(&self, first: usize) -> Result<Vec<DVec3>> {
        self.read_band(first).with_context(|| format!("{}", self.path.display()))
    }

    fn read_band(&self, first: usize) -> Result<Vec<DVec3>> {
        let [width, height] = self.size();
        let rows = first..(first + self.band).min(height);
        let reader = reader(&self.path)?;
        let unchanged = reader.headers().get(self.part) == Some(&self.header);
        ensure!(unchanged, "another file has taken its place");
        let chunks = reader.filter_chunks(false, |_, _, block| {
            block.layer == self.part
                && (block.level.0, block.level.1) == (0, 0)
                && block.pixel_position.1 < rows.end
                && block.pixel_position.1 + block.pixel_size.1 > rows.start
        })?;
        let meta = chunks.meta_data().clone();
        let chunks: Vec<Chunk> = chunks.collect::<exr::error::Result<_>>()?;
        let unpack = |chunk| UncompressedBlock::decompress_chunk(chunk, &meta, false);
        let blocks: Vec<_> =
            chunks.into_par_iter().map(unpack).collect::<exr::error::Result<_>>()?;
        let mut positions = vec![DVec3::splat(f64::NAN); width * rows.len()];
        for block in &blocks {
            self.place(block, first, &mut positions);
        }
        Ok(positions)
    }

    /// Puts a block's positions where they belong among those of the rows from `first` on.
    fn place(&self, block: &UncompressedBlock, first: usize, positions: &mut [DVec3]) {
        let width = self.size()[0];
        let channels = &self.header.channels.list;
        let (left, top) = (block.index.pixel_position.0, block.index.pixel_position.1);
        for line in block.lines(&self.header.channels) {
            let Some(axis) = self.channels.iter().position(|&own| own == line.location.channel)
            else {
                continue;
            };
            let row = line.location.position.1;
            debug_assert!(row >= top && line.location.position.0 == left);
            let Some(start) = row.checked_sub(first).map(|row| row * width + left) else {
                continue;
            };
            let targets = positions.iter_mut().skip(start).take(line.location.sample_count);
            let put = |(target, value): (&mut DVec3, f64)| target[axis] = value;
            match channels[line.location.channel].sample_type {
                SampleType::F32 => targets
                    .zip(line.value.as_chunks::<4>().0)
                    .map(|(target, &bytes)| (target, f64::from(f32::from_ne_bytes(bytes))))
                    .for_each(put),
                SampleType::F16 => targets
                    .zip(line.value.as_chunks::<2>().0)
                    .map(|(target, &bytes)| (target, f16::from_ne_bytes(bytes).to_f64()))
                    .for_each(put),
                SampleType::U32 => targets
                    .zip(line.value.as_chunks::<4>().0)
                    .map(|(target, &bytes)| (target, f64::from(u32::from_ne_bytes(bytes))))
                    .for_each(put),
            }
        }
    }
}

fn reader(path: &Path) -> Result<Reader<BufReader<File>>> {
    let file = File::open(path).with_context(|| format!("{}", path.display()))?;
    let reader = block::read(BufReader::with_capacity(1 << 18, file), false);
    reader.with_context(|| format!("{}", path.display()))
}
