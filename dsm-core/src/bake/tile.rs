//! The compressed functions of a tile, and their errors.

use std::ops::Range;

use super::exact::ExactPixel;
use super::settings::Block;
use crate::compress::compressor::Compression;
use crate::compress::quantization::Quantization;
use crate::compress::rounded::{Rounded, RoundedCompressor};
use crate::error::Result;
use crate::field::pixel_lists::{PixelLists, PixelListsBuilder};
use crate::tolerance::Tolerance;
use crate::transmittance::Transmittance;
use crate::visibility::difference::DifferenceSummary;
use crate::visibility::vertex::Vertex;

/// A tile that was baked.
#[derive(Clone, Debug, PartialEq)]
pub struct BakedTile<T> {
    pub(super) tile: [u32; 2],
    pub(super) pixels: PixelLists<T>,
    pub(super) max_error: f64,
    pub(super) mean_error: f64,
    pub(super) depth_error: f32,
    pub(super) hits: u64,
}

impl<T: Transmittance> BakedTile<T> {
    /// Column and row among the tiles of the whole map.
    #[must_use]
    pub const fn tile(&self) -> [u32; 2] {
        self.tile
    }

    /// The compressed functions.
    #[must_use]
    pub const fn pixels(&self) -> &PixelLists<T> {
        &self.pixels
    }

    /// The largest error of any pixel, measured in `f64` on the `f32` values
    /// against the uncompressed function; where chords stand for exponentials
    /// with what they may be off. Not above the tolerance, but for 2⁻²⁵ below
    /// [`GreedyCompressor::COPY_BELOW`](crate::compress::greedy::GreedyCompressor::COPY_BELOW).
    #[must_use]
    pub const fn max_error(&self) -> f64 {
        self.max_error
    }

    /// The mean of the pixels' mean errors
    /// ([`VisibilityDifference::mean`](crate::visibility::difference::VisibilityDifference::mean)),
    /// measured the same way.
    #[must_use]
    pub const fn mean_error(&self) -> f64 {
        self.mean_error
    }

    /// The largest shift of a depth away from the light, which the errors don't
    /// count ([`Quantization`]); 0 without one.
    #[must_use]
    pub const fn depth_error(&self) -> f32 {
        self.depth_error
    }

    /// Number of surfaces and segments of media that the tile's samples hit,
    /// including those on the border that the filter reaches.
    #[must_use]
    pub const fn hits(&self) -> u64 {
        self.hits
    }
}

/// Compresses the pixels of one tile, in any order.
#[derive(Debug)]
pub(super) struct TileCompressor<T: Transmittance> {
    tolerance: Tolerance,
    compressor: RoundedCompressor<T>,
    block: Block,
    depth_error: f32,
    vertices: Vec<Vertex<T>>,
    /// The vertices of each pixel, row by row.
    pixels: Vec<Range<usize>>,
    differences: DifferenceSummary,
    worst: f64,
    curved: u32,
}

impl<T: Transmittance> TileCompressor<T> {
    pub(super) fn new(
        tolerance: Tolerance,
        quantization: Option<Quantization>,
        compression: Compression,
        block: Block,
    ) -> Self {
        let pixels = block.size[0] as usize * block.size[1] as usize;
        Self {
            tolerance,
            compressor: RoundedCompressor::new(quantization, compression),
            block,
            depth_error: 0.0,
            vertices: Vec::new(),
            pixels: vec![0..0; pixels],
            differences: DifferenceSummary::default(),
            worst: 0.0,
            curved: 0,
        }
    }

    /// Compresses one pixel.
    pub(super) fn push(&mut self, exact: ExactPixel<'_, T>) {
        let [x, y] = [0, 1].map(|axis| (exact.pixel[axis] - self.block.min[axis]) as usize);
        let pixel = y * self.block.size[0] as usize + x;
        let start = self.vertices.len();
        // Only a curved pixel has spent some of the tolerance on chords; the
        // others may spend all of it here.
        let chord_error = if exact.curved { self.tolerance.chord() } else { 0.0 };
        self.curved += u32::from(exact.curved);
        let tolerance = self.tolerance.after(chord_error);
        let Rounded { difference, moved } =
            self.compressor.compress(tolerance, exact.vertices, &mut self.vertices);
        self.worst = self.worst.max(difference.max() + chord_error);
        self.differences.add(pixel, difference);
        self.depth_error = self.depth_error.max(moved);
        self.pixels[pixel] = start..self.vertices.len();
    }

    /// Bytes that the vertices so far take at least, each with a depth and a value.
    pub(super) fn least_bytes(&self) -> u64 {
        8 * self.vertices.len() as u64
    }

    /// The tile with these pixels; those that were not pushed are clear.
    pub(super) fn finish(self, tile: [u32; 2], hits: u64) -> Result<BakedTile<T>> {
        let [width, height] = self.block.size;
        let mut lists = PixelListsBuilder::new(width, height);
        for range in self.pixels {
            self.vertices[range].iter().for_each(|&vertex| lists.push(vertex));
            lists.finish_pixel()?;
        }
        let chord_share = f64::from(self.curved) / self.differences.pixels().max(1) as f64;
        let mean = self.differences.mean() + chord_share * self.tolerance.chord();
        Ok(BakedTile {
            tile,
            pixels: lists.finish()?,
            max_error: self.worst,
            mean_error: mean.min(self.worst),
            depth_error: self.depth_error,
            hits,
        })
    }
}
