//! Which tile a pixel lies in.

/// Cuts columns or rows of pixels into those of tiles, without a division.
#[derive(Clone, Copy, Debug)]
pub(super) struct TileDivision {
    /// Pixels along a side of a tile.
    pub(super) size: u32,
    /// ⌈2⁶³ / size⌉.
    reciprocal: u64,
}

impl TileDivision {
    pub(super) const fn new(size: u32) -> Self {
        Self { size, reciprocal: (1_u64 << 63).div_ceil(size as u64) }
    }

    /// Which tile `at` lies in, and how far from its edge.
    ///
    /// The reciprocal is less than 1 too large, the quotient thus less than
    /// at / 2⁶³ < 1 / size: too little to reach the next integer, for an `at`
    /// and a size below 2³¹.
    #[inline(always)]
    pub(super) const fn split(self, at: u32) -> (u32, u32) {
        let tile = ((at as u128 * self.reciprocal as u128) >> 63) as u32;
        (tile, at - tile * self.size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_divided_as_integers() {
        let edges = [1, 2, 3, 5, 7, 63, 64, 65, 1000, 46_341, (1 << 30) + 1, (1 << 31) - 1];
        for size in edges {
            let division = TileDivision::new(size);
            let near = edges.iter().flat_map(|&at| [at - 1, at, at.saturating_mul(size) - 1]);
            let mixed = (0..10_000_u32).map(|step| step.wrapping_mul(2_654_435_761));
            for at in near.chain(mixed).map(|at| at & 0x7fff_ffff) {
                assert_eq!(division.split(at), (at / size, at % size), "{at} by {size}");
            }
        }
    }
}
