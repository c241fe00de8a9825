//! Dispatch of the work on primitives of one kind by this processor's instruction
//! set.

use fearless_simd::{Level, dispatch};

use super::bins::Bins;
use super::cell_hits::CellHits;
use super::cell_lists::CellLists;
use super::cells::{Cell, CellArea};
use super::kernel;
use super::primitive::Primitive;
use super::rays::Rays;
use super::segment::RaySegment;
use super::triangle::RayTriangle;

/// A kind of primitive whose loops are compiled once for every level of instructions.
/// These are plain
/// functions for each kind, not generic ones: crates that link this one would
/// compile those again.
pub(super) trait DispatchedPrimitive: Primitive {
    /// [`Bins::fill`].
    fn fill(
        level: Level,
        bins: &mut Bins,
        rays: &Rays,
        primitives: &[Self],
        outlines: &[Self::Outline],
    );

    /// [`CellLists::fill`].
    fn list(
        level: Level,
        lists: &mut CellLists,
        bins: &Bins,
        outlines: &[Self::Outline],
        area: &CellArea,
    );

    /// [`kernel::meet`].
    fn meet_all(
        level: Level,
        cell: &Cell,
        primitives: &[Self],
        items: &[u32],
        cell_hits: &mut CellHits,
    );
}

macro_rules! dispatched {
    ($($primitive:ty),*) => {$(
        impl DispatchedPrimitive for $primitive {
            #[inline(never)]
            fn fill(
                level: Level,
                bins: &mut Bins,
                rays: &Rays,
                primitives: &[Self],
                outlines: &[Self::Outline],
            ) {
                // Not for vectors: plain x86-64 rounds numbers by a call.
                dispatch!(level, _simd => bins.fill(rays, primitives, outlines));
            }

            #[inline(never)]
            fn list(
                level: Level,
                lists: &mut CellLists,
                bins: &Bins,
                outlines: &[Self::Outline],
                area: &CellArea,
            ) {
                dispatch!(level, _simd => lists.fill(bins, outlines, area));
            }

            #[inline(never)]
            fn meet_all(
                level: Level,
                cell: &Cell,
                primitives: &[Self],
                items: &[u32],
                cell_hits: &mut CellHits,
            ) {
                dispatch!(level, simd => kernel::meet(simd, cell, primitives, items, cell_hits));
            }
        }
    )*};
}

dispatched!(RaySegment<1>, RaySegment<2>, RayTriangle<1>, RayTriangle<2>);
