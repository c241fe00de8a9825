//! What a bake tells of itself.

/// The counts of a bake.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct BakeReport {
    /// Samples of all pixels.
    pub samples: u64,
    /// Hits of all samples, of those on the borders of tiles that a wide filter
    /// asks for again too.
    pub hits: u64,
    /// Pixels with more layers than the map keeps.
    pub cut_pixels: u64,
    /// The bound of the error of every visibility function.
    pub tolerance: f32,
    /// Numbers a value: 1 or 3.
    pub channels: usize,
    /// Length of the file in bytes.
    pub bytes: u64,
}
