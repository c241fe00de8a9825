//! A tile's pixels, in place or decoded.

use dsm_core::detail::{PixelLists, PixelListsView};

/// The pixels of a tile, whose every function was checked.
#[derive(Clone, Debug)]
pub enum Tile<'a, T> {
    /// They lie in the file as they are used.
    Borrowed(PixelListsView<'a, T>),
    /// They had to be decoded.
    Owned(PixelLists<T>),
}

impl<T: dsm_core::Transmittance> Tile<'_, T> {
    /// The tile's pixels in memory of their own: a copy of those that lie in the
    /// file.
    #[must_use]
    pub fn into_lists(self) -> PixelLists<T> {
        match self {
            Self::Borrowed(pixels) => pixels.to_lists(),
            Self::Owned(pixels) => pixels,
        }
    }

    /// The tile's pixels.
    #[must_use]
    pub fn view(&self) -> PixelListsView<'_, T> {
        match self {
            Self::Borrowed(pixels) => *pixels,
            Self::Owned(pixels) => pixels.view(),
        }
    }
}
