//! Scan lines and tiles.

/// Division of a part's pixels into chunks: scan lines or tiles.
///
/// ```
/// use deep_exr::{Layout, WriteOptions};
///
/// let tiles = Layout::Tiles { width: 64, height: 32 };
/// let grid = WriteOptions::new(100, 100).layout(tiles).grid()?;
/// assert_eq!([grid.columns(), grid.bands()], [2, 4]);
/// # Ok::<(), deep_exr::Error>(())
/// ```
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
