//! Minimum and maximum depths of the parts of a map.

use crate::range_blocks::RangeBlocks;

/// A quadtree over the pixels of a map with the minimum and maximum w = 1/depth of
/// their layers (Xie et al. 2007, §4.3). A node covers 2 × 2 nodes of the level
/// below; nodes without layers are known as empty.
///
/// Memory: 8 bytes a pixel and a third more where layers are, and next to nothing for
/// blocks of pixels without.
///
/// ```
/// use dsm_trace::MinMaxPyramid;
///
/// let ranges = [Some([0.5, 0.75]), None, None, Some([0.25, 0.25])];
/// let pyramid = MinMaxPyramid::new([2, 2], |x, y| ranges[(y * 2 + x) as usize])?;
/// assert_eq!(pyramid.range(), Some([0.25, 0.75]));
/// assert_eq!(pyramid.node(0, 1, 0), None);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct MinMaxPyramid {
    /// The levels, from the pixels up to one node.
    levels: Vec<RangeBlocks>,
}

impl MinMaxPyramid {
    /// The largest number of pixels of a map.
    pub const MAX_PIXELS: u64 = 1 << 28;

    /// The pyramid over pixels with these ranges.
    pub(crate) fn over(pixels: RangeBlocks) -> Self {
        let mut levels = vec![pixels];
        while let Some(below) = levels.last().filter(|level| level.size().iter().any(|&n| n > 1)) {
            levels.push(below.coarser());
        }
        Self { levels }
    }

    /// Width and height of the map in pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.levels[0].size()
    }

    /// Number of levels: the last has one node, the first one a pixel.
    #[must_use]
    pub const fn level_count(&self) -> usize {
        self.levels.len()
    }

    /// Width and height of a level in nodes.
    ///
    /// # Panics
    ///
    /// If there is no such level.
    #[must_use]
    pub fn level_size(&self, level: usize) -> [u32; 2] {
        self.levels[level].size()
    }

    /// The minimum and maximum w of a node; `None` where it is empty or outside the
    /// map.
    ///
    /// # Panics
    ///
    /// If there is no such level.
    #[must_use]
    pub fn node(&self, level: usize, x: u32, y: u32) -> Option<[f32; 2]> {
        let [low, high] = self.levels[level].at(x, y);
        (low <= high).then_some([low, high])
    }

    /// Number of nodes of a level that are empty. O(nodes).
    ///
    /// # Panics
    ///
    /// If there is no such level.
    #[must_use]
    pub fn empty_nodes(&self, level: usize) -> u64 {
        self.levels[level].empty_nodes()
    }

    /// The minimum and maximum w of the map.
    #[must_use]
    pub fn range(&self) -> Option<[f32; 2]> {
        self.node(self.levels.len() - 1, 0, 0)
    }

    /// True if a node holds layers with w in \[`enter`, `leave`\]: both ends count,
    /// so that what lies at a ray's end is left to the leaf.
    pub(crate) fn overlaps(&self, level: usize, x: u32, y: u32, [enter, leave]: [f64; 2]) -> bool {
        let [low, high] = self.levels[level].at(x, y);
        f64::from(low) <= leave && enter <= f64::from(high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// w of a pixel, and nothing in every third.
    fn pixel(x: u32, y: u32) -> Option<[f32; 2]> {
        let low = (x * 7 + y * 13) % 11;
        (!(x + y).is_multiple_of(3)).then_some([low as f32, (low + x) as f32])
    }

    #[test]
    fn nodes_hold_what_their_pixels_hold() {
        for size in [[1, 1], [2, 3], [5, 4], [1, 9], [16, 16], [17, 3], [40, 70]] {
            let pyramid = MinMaxPyramid::new(size, pixel).unwrap();
            for level in 0..pyramid.level_count() {
                let [width, height] = pyramid.level_size(level);
                for (x, y) in (0..width).flat_map(|x| (0..height).map(move |y| (x, y))) {
                    let span = |at: u32, side: u32| (at << level)..((at + 1) << level).min(side);
                    let pixels = span(x, size[0])
                        .flat_map(|x| span(y, size[1]).filter_map(move |y| pixel(x, y)));
                    let expected = pixels.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
                    assert_eq!(pyramid.node(level, x, y), expected, "{size:?} {level} {x} {y}");
                }
            }
            assert_eq!(pyramid.level_size(pyramid.level_count() - 1), [1, 1]);
        }
    }

    #[test]
    fn odd_maps_and_odd_numbers() {
        let empty = MinMaxPyramid::new([0, 5], |_, _| Some([0.0, 1.0])).unwrap();
        assert_eq!(empty.range(), None);
        let nothing = MinMaxPyramid::new([3, 2], |_, _| Some([f32::NAN, 1.0])).unwrap();
        assert_eq!(nothing.range(), None);
        assert!(MinMaxPyramid::new([1 << 20, 1 << 20], |_, _| None).is_err());
    }
}
