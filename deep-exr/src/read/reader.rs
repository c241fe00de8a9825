//! The reader: rows in, columns out.

use std::fmt;
use std::ops::Range;
use std::path::Path;

use super::chunk::ChunkTable;
use super::decoder::Decoder;
use super::header::Header;
use super::part::FileParts;
use super::readable_part::ReadablePart;
use super::source::ByteSource;
use crate::codec::unpack::Unpacker;
use crate::error::{Error, Result};
use crate::limits::Limits;
use crate::rows::DeepRows;
use crate::selection::Selection;

/// Reader of the samples of one part of a deep (or flat) OpenEXR file, some rows at
/// a time.
///
/// ```no_run
/// use deep_exr::{DeepExrReader, Limits};
///
/// # fn main() -> Result<(), deep_exr::Error> {
/// let mut reader = DeepExrReader::open("smoke.exr".as_ref(), None, &Limits::default())?;
/// let height = reader.header().height;
/// for first in (0..height).step_by(64) {
///     let rows = reader.read_rows(first..height.min(first + 64))?;
///     for pixel in 0..rows.pixel_count() {
///         let depths = &rows.z()[rows.pixel(pixel)];
///         println!("{depths:?}");
///     }
/// }
/// # Ok(())
/// # }
/// ```
pub struct DeepExrReader {
    decoder: Decoder,
    /// The last row of blocks that was decoded but not wanted whole.
    cache: DeepRows,
    cached_band: Option<u32>,
}

impl DeepExrReader {
    /// Opens a file and reads its headers: those of the part that `selection` names
    /// (a [`Selection`], or `None` or the name of a part), or of the first deep part,
    /// or of the first flat part with a depth.
    ///
    /// # Errors
    ///
    /// See [`Error`]: the file can't be opened or is no OpenEXR file;
    /// its headers are damaged or beyond `limits`; there is no such part, layer or
    /// channel, none with depth, or several that may be meant; the compression is not
    /// supported.
    pub fn open(path: &Path, selection: impl Into<Selection>, limits: &Limits) -> Result<Self> {
        Self::new(ByteSource::open(path)?, &selection.into(), limits)
    }

    /// Reads from the bytes of a whole file: a vector, a shared slice, a mapped
    /// file. What is unpacked is copied, nothing else.
    ///
    /// # Errors
    ///
    /// Those of [`Self::open`].
    pub fn from_bytes(
        bytes: impl AsRef<[u8]> + Send + Sync + 'static,
        selection: impl Into<Selection>,
        limits: &Limits,
    ) -> Result<Self> {
        Self::new(ByteSource::from_bytes(Box::new(bytes)), &selection.into(), limits)
    }

    fn new(mut source: ByteSource, selection: &Selection, limits: &Limits) -> Result<Self> {
        let file = FileParts::read(&mut source, limits)?;
        let mut part = ReadablePart::new(&file, selection, source.length(), limits)?;
        let table = ChunkTable::read(&mut source, &file, &part)?;
        part.header.found_chunks = table.found();
        Ok(Self {
            cache: part.plan.rows(part.grid.width()),
            cached_band: None,
            decoder: Decoder {
                source,
                part,
                table,
                limits: limits.clone(),
                unpacker: Unpacker::default(),
                chunks: Vec::new(),
            },
        })
    }

    /// Header of the part.
    #[must_use]
    pub fn header(&self) -> &Header {
        &self.decoder.part.header
    }

    /// The samples of some pixel rows, counted from the top of the data
    /// window.
    ///
    /// Only the scan lines or tiles that these rows touch are read and kept;
    /// a row of tiles that is left half used is kept for the next call, so
    /// that walking down the image in bands of any height decodes every tile
    /// once.
    ///
    /// # Errors
    ///
    /// [`Error::RowsOutOfRange`]; and [`Error::Chunk`] and its
    /// like where the file is damaged or beyond the limits. The reader stays
    /// usable for other rows.
    pub fn read_rows(&mut self, rows: Range<u32>) -> Result<DeepRows> {
        let grid = self.decoder.part.grid;
        if rows.start > rows.end || rows.end > grid.height() {
            return Err(Error::RowsOutOfRange {
                start: rows.start,
                end: rows.end,
                height: grid.height(),
            });
        }
        let mut out = self.decoder.part.plan.rows(grid.width());
        let mut y = rows.start;
        while y < rows.end {
            let band = grid.band_of(y);
            let covered = grid.rows(band);
            let end = covered.end.min(rows.end);
            let whole = covered.start == y && covered.end == end;
            if whole && self.cached_band != Some(band) {
                self.decoder.append_band(band, &mut out)?;
            } else {
                self.fill_cache(band)?;
                self.decoder.check_answer(&out, (end - y) as usize * grid.width() as usize, 0)?;
                out.append(&self.cache, y - covered.start..end - covered.start)?;
            }
            y = end;
        }
        Ok(out)
    }

    fn fill_cache(&mut self, band: u32) -> Result<()> {
        if self.cached_band != Some(band) {
            self.cached_band = None;
            self.cache.clear();
            self.decoder.append_band(band, &mut self.cache)?;
            self.cached_band = Some(band);
        }
        Ok(())
    }
}

impl Decoder {
    /// Appends the pixel rows of one row of blocks.
    fn append_band(&mut self, band: u32, out: &mut DeepRows) -> Result<()> {
        if self.part.header.deep {
            self.append_deep_band(band, out)
        } else {
            self.append_flat_band(band, out)
        }
    }
}

impl fmt::Debug for DeepExrReader {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("DeepExrReader").field("header", self.header()).finish_non_exhaustive()
    }
}
