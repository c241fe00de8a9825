//! What a reader accepts before it gives up on a file.

/// Upper limits on what a file may ask a reader to hold.
///
/// Every size that a file states is compared with one of these, and with what
/// a file of its length can physically contain, before memory is taken for it.
/// The defaults are far above what production files need; lower them where
/// files come from strangers, raise them for an unusually large file.
///
/// ```
/// use deep_exr::Limits;
///
/// let mut limits = Limits::default();
/// limits.max_pixels = 4096 * 4096;
/// assert!(limits.max_samples_per_pixel >= 10_000);
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Limits {
    /// Pixels of the image. Default 2²⁸ (16,384 × 16,384).
    pub max_pixels: u64,
    /// Samples of one pixel. Default 2²⁰ (1,048,576).
    pub max_samples_per_pixel: u32,
    /// Bytes of one chunk (a scan line or a tile), unpacked. Default 256 MiB.
    pub max_chunk_bytes: u64,
    /// Bytes that one answer, a band of rows, may take. Default 2 GiB.
    pub max_answer_bytes: u64,
    /// Bytes of all headers together. Default 16 MiB.
    pub max_header_bytes: u64,
    /// Attributes of one header. Default 4,096.
    pub max_attributes: u32,
    /// Channels of one part. Default 1,024.
    pub max_channels: u32,
    /// Parts of one file. Default 1,024.
    pub max_parts: u32,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            max_pixels: 1 << 28,
            max_samples_per_pixel: 1 << 20,
            max_chunk_bytes: 1 << 28,
            max_answer_bytes: 1 << 31,
            max_header_bytes: 1 << 24,
            max_attributes: 4096,
            max_channels: 1024,
            max_parts: 1024,
        }
    }
}
