//! Which parts of a depth image are one surface.

/// A quadtree over the pixels of a view: whether all neighbours within a node, those that
/// share a corner too, are connected (Agrawala et al. 2000, §5.1.1).
#[derive(Clone, Debug)]
pub(super) struct Connected {
    /// From the pixels up, as [`MinMaxPyramid`](dsm_trace::MinMaxPyramid)'s: width, and
    /// flags row by row.
    levels: Vec<(u32, Vec<bool>)>,
}

impl Connected {
    /// Of `size` pixels, whose neighbours `joins` connects. O(pixels · log side).
    pub(super) fn new(size: [u32; 2], joins: impl Fn([u32; 2], [u32; 2]) -> bool) -> Self {
        let [width, height] = size;
        // Whether the four pixels from here on are one surface.
        let window = |x: u32, y: u32| {
            let four = [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]];
            (0..4).all(|a| (0..a).all(|b| joins(four[a], four[b])))
        };
        let wide = width.saturating_sub(1);
        let mut windows = Vec::new();
        for y in 0..height.saturating_sub(1) {
            windows.extend((0..wide).map(|x| window(x, y)));
        }
        let pixels = width as usize * height as usize;
        let mut levels = vec![(width, vec![true; pixels])];
        let mut side = 1_u32;
        loop {
            let (columns, flags) = &levels[levels.len() - 1];
            let rows = flags.len() as u32 / columns.max(&1);
            if (*columns).max(rows) <= 1 {
                return Self { levels };
            }
            side *= 2;
            let size = [columns.div_ceil(2), rows.div_ceil(2)];
            let mut next = Vec::with_capacity(size[0] as usize * size[1] as usize);
            for y in 0..size[1] {
                for x in 0..size[0] {
                    // A node that reaches out of the view is none.
                    let whole = (x + 1) * side <= width && (y + 1) * side <= height;
                    let below =
                        |dx: u32, dy: u32| flags[((2 * y + dy) * columns + 2 * x + dx) as usize];
                    let parts = whole
                        && [(0, 0), (1, 0), (0, 1), (1, 1)].iter().all(|&(dx, dy)| below(dx, dy));
                    let at = |x: u32, y: u32| windows[(y * wide + x) as usize];
                    let middle = |axis: u32| axis * side + side / 2 - 1;
                    let seams = || {
                        (0..side - 1).all(|along| {
                            at(middle(x), y * side + along) && at(x * side + along, middle(y))
                        })
                    };
                    next.push(parts && seams());
                }
            }
            levels.push((size[0], next));
        }
    }

    /// Whether a node is one surface.
    #[inline]
    pub(super) fn node(&self, level: usize, x: u32, y: u32) -> bool {
        let (columns, flags) = &self.levels[level];
        flags[(y * columns + x) as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_are_one_surface_if_all_neighbours_within_are() {
        // Steps of one are connected, others are not.
        let depth = |[x, y]: [u32; 2]| i64::from((x + 2 * y + x * y / 5) % 9);
        for size in [[1, 1], [2, 2], [7, 5], [8, 8], [9, 4], [16, 16]] {
            for reach in [1, 2, 3, 8] {
                let joins = |a: [u32; 2], b: [u32; 2]| (depth(a) - depth(b)).abs() <= reach;
                let tree = Connected::new(size, joins);
                for level in 0..tree.levels.len() {
                    let side = 1 << level;
                    for (x, y) in (0..size[0].div_ceil(side))
                        .flat_map(|x| (0..size[1].div_ceil(side)).map(move |y| (x, y)))
                    {
                        let (left, top) = (x * side, y * side);
                        let within = |at: [u32; 2]| at[0] < left + side && at[1] < top + side;
                        let whole = left + side <= size[0] && top + side <= size[1];
                        let mut expected = whole || level == 0;
                        for a in (left..left + side)
                            .flat_map(|x| (top..top + side).map(move |y| [x, y]))
                            .filter(|_| expected)
                            .collect::<Vec<_>>()
                        {
                            let around =
                                [[1, 0], [0, 1], [1, 1]].map(|d| [a[0] + d[0], a[1] + d[1]]);
                            let near = around.into_iter().filter(|&b| within(b));
                            expected &= near.into_iter().all(|b| joins(a, b));
                            let (right, below) = ([a[0] + 1, a[1]], [a[0], a[1] + 1]);
                            if within(right) && within(below) {
                                expected &= joins(right, below);
                            }
                        }
                        assert_eq!(tree.node(level, x, y), expected, "{size:?} {level} {x} {y}");
                    }
                }
            }
        }
    }
}
