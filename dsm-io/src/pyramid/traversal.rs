//! The order in which a map's tiles are visited.

use dsm_core::detail::MipPyramid;

/// What comes next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// A tile of level 0.
    Tile { x: u32, y: u32 },
    /// All that is in the node of this height, at least 1, came.
    Close { height: u32, x: u32, y: u32 },
}

/// Visits the occupied tiles of level 0 depth first: before another node is
/// entered, all of the last one came. Nodes without an occupied tile do not
/// come at all. Holds a byte a tile.
pub(super) struct Traversal {
    grid: MipPyramid,
    /// Whether there is a tile in the node, by height, row by row.
    occupied: Vec<Vec<bool>>,
    tiles: u64,
    stack: Vec<(u32, Step)>,
}

impl Traversal {
    /// A visit of `columns` × `rows` tiles that ends with the node of height
    /// `top`, or with the first one that holds all tiles, whichever is higher.
    pub(super) fn new(
        [columns, rows]: [u32; 2],
        top: u32,
        is_occupied: impl Fn(u32, u32) -> bool,
    ) -> Self {
        let grid = MipPyramid::new(columns, rows);
        let every = |[columns, rows]: [u32; 2]| {
            (0..rows).flat_map(move |y| (0..columns).map(move |x| [x, y]))
        };
        let tiles: Vec<_> = every([columns, rows]).map(|[x, y]| is_occupied(x, y)).collect();
        let count = tiles.iter().filter(|&&occupied| occupied).count() as u64;
        let mut occupied = vec![tiles];
        for height in 1..grid.level_count() {
            let below = &occupied[height as usize - 1];
            let [width, _] = grid.size(height - 1);
            let nodes = every(grid.size(height)).map(|node| {
                let mut children = grid.children(height, node);
                children.any(|([x, y], _)| below[y as usize * width as usize + x as usize])
            });
            let nodes = nodes.collect();
            occupied.push(nodes);
        }
        let root = top.max(grid.level_count() - 1);
        let visit = Step::Tile { x: 0, y: 0 };
        Self { grid, occupied, tiles: count, stack: vec![(root, visit)] }
    }

    /// How many tiles come.
    pub(super) const fn tile_count(&self) -> u64 {
        self.tiles
    }

    fn is_occupied(&self, height: u32, x: u32, y: u32) -> bool {
        // Above the grid's root, every node holds just the one below.
        let height = height.min(self.grid.level_count() - 1);
        let [width, rows] = self.grid.size(height);
        x < width && y < rows && {
            self.occupied[height as usize][y as usize * width as usize + x as usize]
        }
    }
}

impl Iterator for Traversal {
    type Item = Step;

    fn next(&mut self) -> Option<Step> {
        loop {
            let (height, step) = self.stack.pop()?;
            let Step::Tile { x, y } = step else { return Some(step) };
            if !self.is_occupied(height, x, y) {
                continue;
            }
            let Some(below) = height.checked_sub(1) else { return Some(step) };
            self.stack.push((height, Step::Close { height, x, y }));
            // No child's position can pass that of a tile's.
            let (left, top) = (x.saturating_mul(2), y.saturating_mul(2));
            for (right, down) in [(1, 1), (0, 1), (1, 0), (0, 0)] {
                let child = Step::Tile { x: left + right, y: top + down };
                self.stack.push((below, child));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(size: [u32; 2], top: u32, occupied: &[[u32; 2]]) -> Vec<Step> {
        Traversal::new(size, top, |x, y| occupied.contains(&[x, y])).collect()
    }

    #[test]
    fn a_node_is_closed_before_the_next_is_entered() {
        use Step::{Close, Tile};
        assert_eq!(
            steps([3, 2], 1, &[[2, 0], [1, 1], [0, 0]]),
            [
                Tile { x: 0, y: 0 },
                Tile { x: 1, y: 1 },
                Close { height: 1, x: 0, y: 0 },
                Tile { x: 2, y: 0 },
                Close { height: 1, x: 1, y: 0 },
                Close { height: 2, x: 0, y: 0 },
            ]
        );
        assert_eq!(
            steps([1, 1], 2, &[[0, 0]]),
            [Tile { x: 0, y: 0 }, Close { height: 1, x: 0, y: 0 }, Close { height: 2, x: 0, y: 0 },]
        );
        assert_eq!(steps([1, 1], 0, &[[0, 0]]), [Tile { x: 0, y: 0 }]);
        assert_eq!(
            steps([2, 2], 1, &[[0, 1], [1, 0]])[..2],
            [Tile { x: 1, y: 0 }, Tile { x: 0, y: 1 }]
        );
        assert_eq!(steps([9, 9], 5, &[]), []);
    }

    #[test]
    fn every_occupied_tile_comes_once() {
        for size in [[1, 1], [5, 1], [1, 6], [7, 5], [8, 8]] {
            let is_occupied = |x, y| (x * 3 + y * 5) % 4 != 0;
            let traversal = Traversal::new(size, 0, is_occupied);
            let count = traversal.tile_count();
            let mut tiles: Vec<_> = traversal
                .filter_map(|step| match step {
                    Step::Tile { x, y } => Some([x, y]),
                    Step::Close { .. } => None,
                })
                .collect();
            assert_eq!(tiles.len() as u64, count);
            tiles.sort_unstable();
            let every = (0..size[0]).flat_map(|x| (0..size[1]).map(move |y| [x, y]));
            let expected: Vec<_> = every.filter(|&[x, y]| is_occupied(x, y)).collect();
            assert_eq!(tiles, expected);
        }
    }

    #[test]
    fn a_large_grid_with_few_tiles_takes_few_steps() {
        let corners = [[0, 0], [1999, 0], [1999, 1999]];
        // 11 nodes above each of three corners, the root once.
        assert!(steps([2000, 2000], 11, &corners).len() <= 3 + 3 * 11);
    }
}
