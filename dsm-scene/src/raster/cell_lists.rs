//! The primitives of a block, cell by cell.

use super::bins::Bins;
use super::cells::CellArea;
use super::outline::Rows;

/// The primitives that may cover each cell of a block, in ascending order. Keeps
/// its memory from block to block.
#[derive(Clone, Debug, Default)]
pub(super) struct CellLists {
    /// First cell, number of cells, primitive.
    spans: Vec<[u32; 3]>,
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl CellLists {
    /// Replaces the lists by those of the cells of `area`.
    #[inline(always)]
    pub(super) fn fill<O: Rows>(&mut self, bins: &Bins, outlines: &[O], area: &CellArea) {
        let Self { spans, starts, items } = self;
        let columns = area.columns() as u32;
        spans.clear();
        for (part, near) in bins.parts(area) {
            for &item in near {
                outlines[item as usize].for_rows(&part, |row, first, end| {
                    let row = (row - area.min[1]) as u32 * columns;
                    spans.push([row + (first - area.min[0]) as u32, (end - first) as u32, item]);
                });
            }
        }
        starts.clear();
        starts.resize(area.columns() * area.rows() + 2, 0);
        for &[first, count, _] in &*spans {
            for start in &mut starts[first as usize + 2..][..count as usize] {
                *start += 1;
            }
        }
        let mut start = 0;
        for next in &mut *starts {
            start += *next;
            *next = start;
        }
        items.resize(start as usize, 0);
        // Each cell lies in one bin, so that its items stay in order.
        for &[first, count, item] in &*spans {
            for start in &mut starts[first as usize + 1..][..count as usize] {
                items[*start as usize] = item;
                *start += 1;
            }
        }
        starts.pop();
    }

    /// The primitives that may cover the cell with this number, counted row by row.
    #[inline(always)]
    pub(super) fn cell(&self, cell: usize) -> &[u32] {
        &self.items[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }
}
