//! Tiles of coarser levels while their parts come in.

use std::collections::BTreeMap;

use dsm_core::Transmittance;
use dsm_core::detail::VisibilityView;

use super::fragment::Fragment;
use crate::achieved_error::AchievedError;
use crate::codec::{Codec, Packing};
use crate::columns::Columns;
use crate::error::{Error, Result};
use crate::format::encoded_tile::EncodedTile;
use crate::format::level::Level;
use crate::tile_id::TileId;

/// Parts of a tile by the row and column of their first pixels.
type Parts<T> = BTreeMap<[u32; 2], Fragment<T>>;

/// The one tile of each level that is not finished.
pub(super) struct OpenTiles<T> {
    levels: Vec<Parts<T>>,
}

impl<T: Transmittance> OpenTiles<T> {
    /// Nothing of any of so many levels.
    pub(super) fn new(levels: u32) -> Self {
        Self { levels: (0..levels).map(|_| BTreeMap::new()).collect() }
    }

    /// Adds a part to the tile of `level` that is open.
    pub(super) fn add(&mut self, level: u32, fragment: Fragment<T>) {
        if !fragment.is_clear() {
            let [x, y] = fragment.origin;
            self.levels[level as usize].insert([y, x], fragment);
        }
    }

    /// Takes the tile of a level out: all of it came. None if it has nothing.
    pub(super) fn close(&mut self, id: TileId) -> Option<FinishedTile<T>> {
        let parts = self.levels.get_mut(id.level as usize).map(std::mem::take)?;
        (!parts.is_empty()).then_some(FinishedTile { id, parts })
    }
}

/// All parts of a tile.
pub(super) struct FinishedTile<T> {
    pub(super) id: TileId,
    parts: Parts<T>,
}

impl<T: Transmittance> FinishedTile<T> {
    /// Puts the parts together, and encodes them. O(pixels + vertices).
    pub(super) fn encode(
        &self,
        level: &Level,
        (codec, packing): (Codec, Packing),
    ) -> Result<(EncodedTile, AchievedError)> {
        let Self { id, parts } = self;
        let rect = level.tile_rect(id.x, id.y).ok_or(Error::NoSuchTile(*id))?;
        let (mut max, mut means) = (0.0_f64, 0.0);
        for part in parts.values() {
            max = max.max(part.max);
            means += part.means;
        }
        let error = AchievedError::enclosing(max, means / rect.pixel_count().max(1) as f64);
        let mut tile = Columns::default();
        for y in rect.y..rect.y + rect.height {
            let mut here = rect.x;
            for part in row_of(parts, y) {
                let pixels = part.pixels.view();
                let [left, top] = part.origin;
                (here..left).try_for_each(|_| tile.push::<T>(VisibilityView::clear()))?;
                (0..pixels.width()).try_for_each(|x| tile.push(pixels.pixel(x, y - top)))?;
                here = left + pixels.width();
            }
            (here..rect.x + rect.width)
                .try_for_each(|_| tile.push::<T>(VisibilityView::clear()))?;
        }
        let tile = tile.finish::<T>(rect.width, rect.height)?;
        Ok((EncodedTile::encode(tile.view(), codec, packing)?, error))
    }
}

/// The parts that have pixels in row `y`, from left to right. All parts of one
/// tile stand on one grid.
fn row_of<T: Transmittance>(parts: &Parts<T>, y: u32) -> impl Iterator<Item = &Fragment<T>> {
    let last = parts.range(..=[y, u32::MAX]).next_back();
    let top = last.map_or(0, |(&[top, _], _)| top);
    let row = parts.range([top, 0]..=[top, u32::MAX]).map(|(_, part)| part);
    row.filter(move |part| y - top < part.pixels.view().height())
}
