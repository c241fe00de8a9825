//! Ranges of nodes in blocks, of which only those that hold something take memory.

/// The range of a node without layers.
pub(crate) const EMPTY: [f32; 2] = [f32::INFINITY, f32::NEG_INFINITY];

/// Nodes along the side of a block, as a power of two.
const SIDE_LOG2: u32 = 4;
const SIDE: u32 = 1 << SIDE_LOG2;
const NODES: usize = 1 << (2 * SIDE_LOG2);

/// A range a node of a grid; an empty node's minimum is above its maximum.
#[derive(Clone, Debug)]
pub(crate) struct RangeBlocks {
    size: [u32; 2],
    columns: u32,
    /// Every block's place among `ranges`, in blocks; the one at 0 is empty.
    table: Vec<u32>,
    ranges: Vec<[f32; 2]>,
}

impl RangeBlocks {
    /// A grid of empty nodes.
    pub(crate) fn new(size: [u32; 2]) -> Self {
        let [columns, rows] = size.map(|side| side.div_ceil(SIDE));
        let table = vec![0; columns as usize * rows as usize];
        Self { size, columns, table, ranges: vec![EMPTY; NODES] }
    }

    pub(crate) const fn size(&self) -> [u32; 2] {
        self.size
    }

    const fn block(&self, x: u32, y: u32) -> usize {
        (y >> SIDE_LOG2) as usize * self.columns as usize + (x >> SIDE_LOG2) as usize
    }

    const fn node(x: u32, y: u32) -> usize {
        ((y & (SIDE - 1)) << SIDE_LOG2 | (x & (SIDE - 1))) as usize
    }

    /// The range of a node: empty outside the grid.
    pub(crate) fn at(&self, x: u32, y: u32) -> [f32; 2] {
        if x < self.size[0] && y < self.size[1] {
            self.ranges[self.table[self.block(x, y)] as usize * NODES + Self::node(x, y)]
        } else {
            EMPTY
        }
    }

    /// Sets the range of a node.
    ///
    /// # Panics
    ///
    /// If the node lies outside the grid.
    pub(crate) fn set(&mut self, [x, y]: [u32; 2], range: [f32; 2]) {
        assert!(x < self.size[0] && y < self.size[1], "a node outside the grid");
        let block = self.block(x, y);
        if self.table[block] == 0 {
            if range == EMPTY {
                return;
            }
            // As many blocks as a table of 2²⁸ pixels has fit.
            self.table[block] = (self.ranges.len() / NODES) as u32;
            self.ranges.resize(self.ranges.len() + NODES, EMPTY);
        }
        self.ranges[self.table[block] as usize * NODES + Self::node(x, y)] = range;
    }

    /// The grid whose nodes hold what each four of this one hold together.
    pub(crate) fn coarser(&self) -> Self {
        let mut coarser = Self::new(self.size.map(|side| side.div_ceil(2)));
        let half = SIDE / 2;
        for (block, _) in self.table.iter().enumerate().filter(|&(_, &place)| place != 0) {
            let [left, top] =
                [block as u32 % self.columns, block as u32 / self.columns].map(|at| at * half);
            for (y, x) in (top..top + half).flat_map(|y| (left..left + half).map(move |x| (y, x))) {
                let corners = [(0, 0), (1, 0), (0, 1), (1, 1)];
                let range = corners.into_iter().fold(EMPTY, |[low, high], (dx, dy)| {
                    let [min, max] = self.at(2 * x + dx, 2 * y + dy);
                    [low.min(min), high.max(max)]
                });
                if range != EMPTY {
                    coarser.set([x, y], range);
                }
            }
        }
        coarser
    }

    /// Number of nodes that are empty. O(blocks, and nodes of those that are not).
    pub(crate) fn empty_nodes(&self) -> u64 {
        let held = self.ranges.iter().filter(|[low, high]| low <= high).count() as u64;
        u64::from(self.size[0]) * u64::from(self.size[1]) - held
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_empty_takes_next_to_nothing() {
        let mut blocks = RangeBlocks::new([1 << 14, 1 << 14]);
        for pixel in [[5, 7], [6, 7], [(1 << 14) - 1, 3]] {
            blocks.set(pixel, [0.25, 0.5]);
        }
        blocks.set([900, 900], EMPTY);
        assert_eq!(blocks.ranges.len(), 3 * NODES);
        assert_eq!(blocks.empty_nodes(), (1 << 28) - 3);
        assert_eq!((blocks.at(6, 7), blocks.at(7, 7)), ([0.25, 0.5], EMPTY));
        assert_eq!(blocks.at(1 << 14, 3), EMPTY);
        let coarser = blocks.coarser();
        assert_eq!((coarser.at(2, 3), coarser.at(3, 3)), ([0.25, 0.5], [0.25, 0.5]));
        assert_eq!(coarser.empty_nodes(), (1 << 26) - 3);
    }
}
