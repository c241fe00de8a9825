//! Limits of what a reader accepts of a file.

/// Upper limits on the memory and the parts that a map's file may require.
///
/// A reader compares each stated size with its limit, and with what a file of
/// that length can hold, before it allocates. Production files stay far below
/// the defaults: lower them for strangers' files, raise them for a huge one.
///
/// ```
/// use dsm_io::Limits;
///
/// let mut limits = Limits::default();
/// limits.max_pixels = 4096 * 4096;
/// limits.images.max_samples_per_pixel = 10_000;
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Limits {
    /// Pixels of one map. Default 2²⁸ (16,384 × 16,384).
    pub max_pixels: u64,
    /// Bytes of one tile, unpacked. Default 256 MiB.
    pub max_chunk_bytes: u64,
    /// Bytes of the metadata. Default 16 MiB.
    pub max_header_bytes: u64,
    /// Levels of one map, over all views. Default 4,096.
    pub max_levels: u32,
    /// Tiles of one map, over all levels. Default 2²².
    pub max_tiles: u64,
    /// Sections of one file. Default 65,536.
    pub max_sections: u32,
    /// Bytes of a file or of a map's level that is read into memory. Default
    /// 16 GiB.
    pub max_in_memory_bytes: u64,
    /// The limits of OpenEXR images that are converted.
    pub images: deep_exr::Limits,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            max_pixels: 1 << 28,
            max_chunk_bytes: 1 << 28,
            max_header_bytes: 1 << 24,
            max_levels: 1 << 12,
            max_tiles: 1 << 22,
            max_sections: 1 << 16,
            max_in_memory_bytes: 1 << 34,
            images: deep_exr::Limits::default(),
        }
    }
}
