//! The pixels of a tile of any kind.

use std::fmt::Debug;

use dsm_core::Transmittance;
use dsm_core::detail::PixelLists;

/// The decoded pixels of a tile, in memory of their own.
pub trait MapTile: Debug + Send + Sync + 'static {
    /// Width and height in pixels.
    fn size(&self) -> [u32; 2];

    /// Bytes of memory that the pixels take: what the budget of a
    /// [`TileCache`](crate::cache::TileCache) counts.
    fn bytes(&self) -> u64;
}

impl<T: Transmittance> MapTile for PixelLists<T> {
    // Asked at every lookup.
    #[inline(always)]
    fn size(&self) -> [u32; 2] {
        let view = self.view();
        [view.width(), view.height()]
    }

    fn bytes(&self) -> u64 {
        let view = self.view();
        let tables = view.starts().len() + view.value_starts().len();
        4 * (tables + view.depths().len() + view.values().len()) as u64
    }
}
