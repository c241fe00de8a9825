//! In which order the rays of a packet visit what they may meet.

use super::cone::Cone;
use super::range_tree::bits;

/// From the apex of a packet outwards: along each axis, the way that most of its
/// rays go.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VisitOrder {
    /// Turns the number of a node of 4 × 4 around, so that the farthest is 0.
    flip: u32,
}

impl VisitOrder {
    #[inline(always)]
    pub(crate) fn new(cone: &Cone) -> Self {
        let [right, down] = cone.slopes.map(|[least, most]| least + most >= 0.0);
        Self { flip: (u32::from(right) * 3) | (u32::from(down) * 12) }
    }

    /// How far along this way a place lies, of places on one level.
    #[inline(always)]
    pub(crate) fn distance(self, at: [u32; 2]) -> i64 {
        let [x, y] = at.map(i64::from);
        let along = |forward: bool, at: i64| if forward { at } else { -at };
        along(self.flip & 3 != 0, x) + along(self.flip & 12 != 0, y)
    }

    /// The nodes in a set of 4 × 4, row by row.
    #[inline(always)]
    pub(crate) fn farthest_first(self, mut set: u32) -> impl Iterator<Item = usize> {
        if self.flip & 3 != 0 {
            set = (set & 0x5555) << 1 | (set & 0xaaaa) >> 1;
            set = (set & 0x3333) << 2 | (set & 0xcccc) >> 2;
        }
        if self.flip & 12 != 0 {
            set = (set & 0x0f0f) << 4 | (set & 0xf0f0) >> 4;
            set = (set & 0x00ff) << 8 | (set & 0xff00) >> 8;
        }
        bits(set).map(move |bit| bit ^ self.flip as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_node_comes_once_and_none_before_a_farther_one_of_its_row_or_column() {
        for (x, y) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            let cone = Cone {
                slopes: [[x - 0.5, x + 0.5], [y - 0.5, y + 0.5]],
                ..Cone::empty([0.0; 2], 0.0)
            };
            let order = VisitOrder::new(&cone);
            for set in [0_u32, 1, 0x8421, 0x0f3c, 0xffff] {
                let nodes: Vec<_> = order.farthest_first(set).collect();
                assert_eq!(nodes.iter().fold(0, |all, node| all | 1_u32 << node), set);
                assert_eq!(nodes.len(), set.count_ones() as usize);
                let place = |node: usize| [node as u32 % 4, node as u32 / 4];
                for (first, second) in nodes.iter().zip(nodes.iter().skip(1)) {
                    let [first, second] = [place(*first), place(*second)];
                    if first[0] == second[0] || first[1] == second[1] {
                        assert!(order.distance(first) > order.distance(second));
                    }
                }
            }
        }
    }
}
