//! How written chunks are compressed.

use crate::codec::packing::Packing;

/// Compression of a written image's chunks.
///
/// ```
/// use deep_exr::{Compression, DeepExrReader, DeepExrWriter, Limits, WriteOptions};
///
/// let options = WriteOptions::new(2, 1).compression(Compression::Rle);
/// let mut writer = DeepExrWriter::new(std::io::Cursor::new(Vec::new()), &options)?;
/// let mut rows = options.rows(2);
/// rows.finish_pixel()?;
/// rows.finish_pixel()?;
/// writer.write_rows(&rows)?;
/// let bytes = writer.finish()?.into_inner();
/// let reader = DeepExrReader::from_bytes(bytes, None, &Limits::default())?;
/// assert_eq!(reader.header().compression, "RLE");
/// # Ok::<(), deep_exr::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Compression {
    /// Deflate, a scan line or tile at a time.
    #[default]
    Zips,
    /// Run lengths.
    Rle,
    /// Zstandard, new in OpenEXR 3.5: older readers refuse it.
    Zstd,
    /// Not at all.
    None,
}

impl Compression {
    pub(crate) const fn packing(self) -> Packing {
        match self {
            Self::Zips => Packing::Zips,
            Self::Rle => Packing::Rle,
            Self::Zstd => Packing::Zstd,
            Self::None => Packing::None,
        }
    }
}
