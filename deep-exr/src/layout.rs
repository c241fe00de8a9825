//! How the pixels of an image are cut into chunks.

/// How the pixels of a part are cut into chunks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Layout {
    /// Scan lines over the whole width.
    #[default]
    ScanLines,
    /// Tiles, row by row.
    Tiles {
        /// Pixels of a whole tile.
        width: u32,
        /// Pixels of a whole tile.
        height: u32,
    },
}
