//! Maps of fragments, a tile at a time.

use dsm_core::detail::Result;
use dsm_core::{HitSource, Transmittance};
use dsm_io::AchievedError;
use dsm_io::detail::TileRect;
use rayon::prelude::*;

use super::builder::{FragmentBuilder, PixelBlock, Scratch, TILE, append, append_media};
use super::columns::FragmentColumns;
use super::groups::SampleGrid;
use super::media::columns::MediaColumns;
use super::tile::FragmentTile;

/// The fragments of a tile, and what was counted on the way.
pub(super) struct BuiltTile<T> {
    pub(super) tile: FragmentTile<T>,
    pub(super) error: AchievedError,
    pub(super) hits: u64,
    pub(super) cut_pixels: u64,
    pub(super) most_gained: f64,
    pub(super) sum_gained: f64,
}

/// A block of pixels of a tile, by its place there.
struct TileBlock {
    tile: usize,
    min: [u32; 2],
    size: [u32; 2],
}

impl FragmentBuilder {
    /// Builds these tiles of the map, in their order; blocks of all of them in parallel. A tile
    /// comes out the same whatever others are asked for. O(h log h) for the h hits of a pixel.
    ///
    /// # Errors
    ///
    /// As [`Self::build`].
    pub(super) fn tiles<T, S>(
        &self,
        source: &S,
        rects: &[TileRect],
    ) -> std::result::Result<Vec<BuiltTile<T>>, S::Error>
    where
        T: Transmittance,
        S: HitSource<T>,
    {
        let grid = SampleGrid::new(self.coverage(), self.frame().footprint(1.0));
        let places: Vec<TileBlock> =
            rects.iter().enumerate().flat_map(|(tile, rect)| blocks_of(tile, *rect)).collect();
        let blocks: std::result::Result<Vec<_>, S::Error> = places
            .par_iter()
            .map_init(
                || Scratch::new(self.tolerance()),
                |scratch, place| self.block(source, place.min, place.size, &grid, scratch),
            )
            .collect();
        let (mut blocks, mut places) = (blocks?.into_iter(), places.iter().peekable());
        let mut tiles = Vec::with_capacity(rects.len());
        for (index, rect) in rects.iter().enumerate() {
            let mut own = Vec::new();
            while places.next_if(|place| place.tile == index).is_some() {
                own.extend(blocks.next());
            }
            tiles.push(joined(&own, *rect, source.has_media())?);
        }
        Ok(tiles)
    }
}

/// The blocks of a tile, row by row.
fn blocks_of(tile: usize, rect: TileRect) -> impl Iterator<Item = TileBlock> {
    let steps = |length: u32| (0..length).step_by(TILE as usize);
    steps(rect.height).flat_map(move |y| {
        steps(rect.width).map(move |x| TileBlock {
            tile,
            min: [rect.x + x, rect.y + y],
            size: [rect.width - x, rect.height - y].map(|side| side.min(TILE)),
        })
    })
}

/// The tile that blocks make, row by row of them.
fn joined<T: Transmittance>(
    blocks: &[PixelBlock<T>],
    rect: TileRect,
    has_media: bool,
) -> Result<BuiltTile<T>> {
    let mut lists = FragmentColumns::new();
    let mut media = MediaColumns::new();
    let mut errors = Vec::new();
    let columns = rect.width.div_ceil(TILE) as usize;
    for (row, blocks) in (0..).zip(blocks.chunks(columns)) {
        for y in 0..TILE.min(rect.height - row * TILE) {
            blocks.iter().try_for_each(|block| append(&mut lists, block, y))?;
            blocks.iter().try_for_each(|block| append_media(&mut media, &mut errors, block, y))?;
        }
    }
    let tile = FragmentTile::new([rect.width, rect.height], lists)?;
    let tile = if has_media { tile.with_media(media)? } else { tile };
    let most = errors.iter().copied().fold(0.0, f32::max);
    let sum: f64 = errors.iter().copied().map(f64::from).sum();
    let mean = sum / errors.len().max(1) as f64;
    let all = || blocks.iter().map(|block| &block.counts);
    Ok(BuiltTile {
        tile,
        error: AchievedError::enclosing(most.into(), mean),
        hits: all().map(|counts| counts.hits).sum(),
        cut_pixels: all().map(|counts| counts.cut_pixels).sum(),
        most_gained: all().map(|counts| counts.most_gained).fold(0.0, f64::max),
        sum_gained: all().map(|counts| counts.mean_gained).sum(),
    })
}
