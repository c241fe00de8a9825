//! A tile that a cursor holds.

use std::ops::Range;

use dsm_core::Transmittance;
use dsm_core::detail::BlockVisitor;

use super::tile::{CachedTile, Held};
use crate::kind::map_kind::FieldKind;
use crate::map_tile::MapTile;

/// A tile that was asked for, at the place that its position gives it.
#[derive(Debug)]
pub(super) struct Slot<P> {
    pub(super) tile: [u32; 2],
    /// `None`: the tile is empty.
    pub(super) pixels: Held<P>,
}

impl<P> Slot<P> {
    /// No tile stands there: a level has fewer than 2³¹ columns.
    pub(super) const VACANT: Self = Self { tile: [u32::MAX; 2], pixels: None };

    pub(super) fn bytes(&self) -> u64 {
        self.pixels.as_ref().map_or(0, |pixels| pixels.bytes())
    }

    /// The pixels, if the tile is not empty.
    #[inline(always)]
    pub(super) fn tile(&self) -> Option<&P> {
        self.pixels.as_deref().map(CachedTile::pixels)
    }
}

/// Hands `visitor` a block that lies within the tile of `slot` with this
/// corner. Tells how many pixels were asked.
#[inline(always)]
pub(super) fn evaluate_block<K: FieldKind, T: Transmittance>(
    slot: &Slot<K::Tile<T>>,
    [left, top]: [u32; 2],
    columns: &Range<u32>,
    rows: Range<u32>,
    visitor: &mut impl BlockVisitor<T>,
) -> u64 {
    let mut asked = 0;
    let Some(pixels) = slot.tile() else {
        for row in rows {
            asked += take_clear(within(columns, visitor.columns(row)), visitor);
        }
        return asked;
    };
    // Once, not once a row.
    let (view, width) = (K::view(pixels), pixels.size()[0] as usize);
    for row in rows {
        let run = within(columns, visitor.columns(row));
        let first = (row - top) as usize * width;
        let ahead = (run.start - left) as usize;
        asked += K::evaluate_run(view, run, first + ahead, visitor);
    }
    asked
}

/// Hands `visitor` a run of pixels of a row that was begun, which lies within the
/// tile of `slot` with this corner. Tells how many were asked.
#[inline(always)]
pub(super) fn evaluate_run<K: FieldKind, T: Transmittance>(
    slot: &Slot<K::Tile<T>>,
    [left, top]: [u32; 2],
    row: u32,
    run: Range<u32>,
    visitor: &mut impl BlockVisitor<T>,
) -> u64 {
    if run.is_empty() {
        return 0;
    }
    let Some(pixels) = slot.tile() else {
        return take_clear(run, visitor);
    };
    let first = (row - top) as usize * pixels.size()[0] as usize;
    let ahead = (run.start - left) as usize;
    K::evaluate_run(K::view(pixels), run, first + ahead, visitor)
}

/// What a range has in common with its bounds: a visitor may be anybody's.
#[inline(always)]
pub(super) fn within(bounds: &Range<u32>, range: Range<u32>) -> Range<u32> {
    range.start.max(bounds.start)..range.end.min(bounds.end)
}

/// Hands `visitor` the values of pixels that are 1 everywhere. Tells how many
/// were asked.
#[inline(always)]
pub(super) fn take_clear<T: Transmittance>(
    columns: Range<u32>,
    visitor: &mut impl BlockVisitor<T>,
) -> u64 {
    let mut asked = 0;
    for column in columns {
        if visitor.depth(column).is_some() {
            visitor.take(T::CLEAR);
            asked += 1;
        }
    }
    asked
}
