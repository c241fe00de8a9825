//! Lists with the sums that lookups read.

use dsm_core::Transmittance;
use dsm_io::detail::MapTile;

use super::lists::FragmentLists;
use super::sums::{ListSums, ListView};

/// The lists of a level or of a tile of one, ready for lookups.
///
/// Memory: 16 bytes a fragment (40 in colour) and 12 a texel (28).
#[derive(Clone, Debug, PartialEq)]
pub struct PrefilteredTile<T> {
    lists: FragmentLists<T>,
    sums: ListSums<T>,
}

impl<T: Transmittance> PrefilteredTile<T> {
    /// Makes lists ready. O(fragments).
    #[must_use]
    pub fn new(lists: FragmentLists<T>) -> Self {
        let sums = ListSums::new(&lists);
        Self { lists, sums }
    }

    /// The lists.
    #[must_use]
    pub const fn lists(&self) -> &FragmentLists<T> {
        &self.lists
    }

    /// The list of the texel with row-major index `texel`.
    #[inline]
    pub(super) fn view(&self, texel: usize) -> ListView<'_, T> {
        self.sums.view(&self.lists, texel)
    }
}

impl<T: Transmittance> MapTile for PrefilteredTile<T> {
    #[inline]
    fn size(&self) -> [u32; 2] {
        self.lists.size()
    }

    fn bytes(&self) -> u64 {
        let lists = size_of_val(self.lists.starts())
            + size_of_val(self.lists.w())
            + size_of_val(self.lists.opacities());
        lists as u64 + self.sums.bytes()
    }
}
