//! The work on primitives of one kind, with the instructions of this processor.

use fearless_simd::{Level, dispatch};

use super::bins::Bins;
use super::cell_lists::CellLists;
use super::cells::{Cell, CellArea};
use super::found::Found;
use super::kernel;
use super::primitive::Primitive;
use super::rays::Rays;
use super::segment::RaySegment;
use super::triangle::RayTriangle;

/// What is compiled once for every level of instructions. These are plain
/// functions for each kind, not generic ones: crates that link this one would
/// compile those again.
pub(super) trait Leveled: Primitive {
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
    fn meet_all(level: Level, cell: &Cell, primitives: &[Self], items: &[u32], found: &mut Found);
}

macro_rules! leveled {
    ($($primitive:ty),*) => {$(
        impl Leveled for $primitive {
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
                found: &mut Found,
            ) {
                dispatch!(level, simd => kernel::meet(simd, cell, primitives, items, found));
            }
        }
    )*};
}

leveled!(RaySegment<1>, RaySegment<2>, RayTriangle<1>, RayTriangle<2>);
