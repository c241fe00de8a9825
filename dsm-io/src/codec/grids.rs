//! Depths and values that lie on grids, as numbers.

use dsm_core::Transmittance;
use dsm_core::detail::PixelListsView;

/// The most bits behind the point that a value may have: an `f32` in (½, 1]
/// has no more.
const MOST_VALUE_BITS: u32 = 24;

/// The most bits of a depth that may be zero: the mantissa's.
const MOST_DEPTH_ZEROS: u32 = 23;

/// The grids of a tile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Grids {
    /// Low bits of a depth that are zero.
    pub(super) depth_zeros: u32,
    /// Bits of a value behind the point.
    pub(super) value_bits: u32,
}

impl Grids {
    /// The most zeros that a depth's code may end with where pixels have a coarser grid.
    pub(super) const MOST_SHIFT: u32 = 30;

    /// The coarsest grids on which all vertices lie; none if values are finer
    /// than any.
    pub(super) fn of<T: Transmittance>(pixels: PixelListsView<'_, T>) -> Option<Self> {
        let depths = pixels.depths().iter().fold(0, |all, z| all | z.to_bits());
        let scale = f32::from_bits((127 + MOST_VALUE_BITS) << 23);
        let mut multiples = 1 << MOST_VALUE_BITS;
        for value in pixels.values() {
            let multiple = value * scale;
            if multiple.fract() != 0.0 {
                return None;
            }
            multiples |= multiple as u32;
        }
        Some(Self {
            depth_zeros: depths.trailing_zeros().min(MOST_DEPTH_ZEROS),
            value_bits: MOST_VALUE_BITS - multiples.trailing_zeros(),
        })
    }

    pub(super) const fn header(self) -> u32 {
        self.depth_zeros | self.value_bits << 8
    }

    pub(super) const fn from_header(word: u32) -> Option<Self> {
        let (depth_zeros, value_bits) = (word & 0xff, word >> 8);
        if depth_zeros <= MOST_DEPTH_ZEROS && value_bits <= MOST_VALUE_BITS {
            Some(Self { depth_zeros, value_bits })
        } else {
            None
        }
    }

    /// The value 1.
    pub(super) const fn one(self) -> u32 {
        1 << self.value_bits
    }

    pub(super) fn value_code(self, value: f32) -> u32 {
        (value * self.one() as f32) as u32
    }

    pub(super) fn value(self, code: u32) -> f32 {
        // At most 24 bits over a power of two.
        code as f32 / self.one() as f32
    }
}

/// Numbers of either sign as small ones: 0, −1, 1, −2, 2 …
pub(super) const fn zigzag(change: u32) -> u32 {
    let change = change.cast_signed();
    ((change << 1) ^ (change >> 31)).cast_unsigned()
}

pub(super) const fn from_zigzag(code: u32) -> u32 {
    (code >> 1) ^ (code & 1).wrapping_neg()
}
