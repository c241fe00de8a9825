//! All that one tile of level 0 is to the levels above it.

use dsm_core::Transmittance;

use super::fragment::{Averager, Copies, CopiesBuilder, Fragment, FragmentBuilder};
use super::plan::Plan;
use super::source::{PixelFunctions, SourceTile};
use crate::achieved_error::AchievedError;
use crate::codec::{Codec, Packing};
use crate::error::Result;
use crate::format::encoded_tile::EncodedTile;
use crate::tile_id::{TileId, TileRect};

/// What a tile of level 0 gives to every level.
pub(super) struct TileLevels<T> {
    /// The tile itself, if there is something to write.
    pub(super) level_zero: Option<(EncodedTile, AchievedError)>,
    /// Its part of level 1 and so on, up to the level of cells; none if the
    /// tile is empty.
    pub(super) fragments: Vec<Fragment<T>>,
    /// Its pixels of the level of cells, for the levels above.
    pub(super) copies: Option<Copies<T>>,
}

impl<T: Transmittance> TileLevels<T> {
    /// Averages the functions of tile `id`, which has these pixels. O(n log n)
    /// a level for n vertices.
    pub(super) fn new<F: PixelFunctions<T>>(
        plan: &Plan,
        id: TileId,
        rect: TileRect,
        tile: SourceTile<F>,
        (codec, packing): (Codec, Packing),
    ) -> Result<Self> {
        let SourceTile { functions, stored } = tile;
        let Some(functions) = functions else {
            return Ok(Self { level_zero: stored, fragments: Vec::new(), copies: None });
        };
        let mut work = TileWork { plan, rect, functions, averager: Averager::default() };
        let node = [id.x, id.y];
        let mut fragments = Vec::new();
        let mut copies = None;
        // A tile that is stored already needs no level 0, but perhaps copies.
        let first = u32::from(stored.is_some() && plan.cell_level > 0);
        for level in first..=plan.cell_level {
            let (fragment, copied) = work.level(level, node)?;
            fragments.push(fragment);
            copies = copied;
        }
        let own = (first == 0 && !fragments.is_empty()).then(|| fragments.remove(0));
        let level_zero = match (stored, own) {
            (None, Some(own)) => {
                let achieved =
                    AchievedError::enclosing(own.max, own.means / rect.pixel_count().max(1) as f64);
                Some((EncodedTile::encode(own.pixels.view(), codec, packing)?, achieved))
            }
            (stored, _) => stored,
        };
        Ok(Self { level_zero, fragments, copies })
    }
}

/// The functions of a tile while they are averaged.
struct TileWork<'a, T: Transmittance, F> {
    plan: &'a Plan,
    rect: TileRect,
    functions: F,
    averager: Averager<T>,
}

impl<T: Transmittance, F: PixelFunctions<T>> TileWork<'_, T, F> {
    /// The tile's part of a level, and copies of it if there are to be any.
    fn level(&mut self, level: u32, node: [u32; 2]) -> Result<(Fragment<T>, Option<Copies<T>>)> {
        let Self { plan, rect, functions, averager } = self;
        let TileRect { width, height, .. } = *rect;
        let side = 1_u32 << level;
        let origin = [rect.x, rect.y].map(|first| first >> level);
        let size = [width, height].map(|pixels| pixels.div_ceil(side));
        let mut fragment =
            FragmentBuilder::new(origin, size, plan.tolerance(level), plan.compression);
        let mut copies = CopiesBuilder::new(size, plan.copy_tolerance(level), plan.compression);
        let mut parts = Vec::new();
        for (row, column) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (y, x))) {
            let reach = |index: u32, end: u32| {
                let first = index * side;
                first..first.saturating_add(side).min(end)
            };
            let (columns, rows) = (reach(column, width), reach(row, height));
            let weight = 1.0 / (columns.len() as f64 * rows.len() as f64);
            let mut inherited = 0.0;
            parts.clear();
            for y in rows {
                let first = y as usize * width as usize;
                for pixel in columns.clone().map(|x| first + x as usize) {
                    parts.push((weight, functions.function(pixel)));
                    inherited += weight * functions.error(pixel);
                }
            }
            if let Some(average) = averager.average(&parts) {
                fragment.push(average, inherited)?;
                copies.push(average, inherited)?;
            } else {
                fragment.push_clear()?;
                copies.push_clear()?;
            }
        }
        Ok((fragment.finish()?, copies.finish(node)?))
    }
}
