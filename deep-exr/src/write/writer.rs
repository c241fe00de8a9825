//! Writing deep images, by rows or chunk by chunk.

use std::fmt;
use std::io::{Seek, SeekFrom, Write};

use super::encoder::{ChunkEncoder, EncodedChunk};
use super::options::WriteOptions;
use super::output_header::OutputHeader;
use crate::error::{Error, Result};
use crate::grid::{Block, ChunkGrid};
use crate::rows::DeepRows;

/// Writer of a deep image of one part, to the start of a file or of anything else
/// that can seek.
///
/// The header and the table of the chunks' places stand first in a file and
/// are known last: they are written once more by [`finish`](Self::finish), and
/// a file without that call has an empty table: some readers look through it for the
/// chunks, others refuse it. Nothing is kept but
/// that table, 8 bytes a chunk, and of tiled images one row of tiles that is
/// not yet whole. Calls are small: give a file a buffer.
///
/// ```
/// use deep_exr::{DeepExrReader, DeepExrWriter, DeepSample, Limits, WriteOptions};
///
/// let options = WriteOptions::new(4, 2);
/// let mut writer = DeepExrWriter::new(std::io::Cursor::new(Vec::new()), &options)?;
/// for y in 0..2 {
///     let mut rows = options.rows(4);
///     for x in 0..4 {
///         // A slab that stops half of the light, behind it a wall.
///         rows.push(DeepSample { z: 1.0, z_back: 1.5, alpha: [0.5; 3] });
///         rows.push(DeepSample { z: 2.0 + x as f32, z_back: 2.0 + x as f32, alpha: [1.0; 3] });
///         rows.finish_pixel()?;
///     }
///     writer.write_rows(&rows)?;
/// }
/// let file = writer.finish()?.into_inner();
///
/// let mut reader = DeepExrReader::from_bytes(file, None, &Limits::default())?;
/// let rows = reader.read_rows(0..2)?;
/// assert_eq!(rows.sample_count(), 16);
/// assert_eq!(rows.sample(rows.pixel(6).start + 1).z, 4.0);
/// # Ok::<(), deep_exr::Error>(())
/// ```
pub struct DeepExrWriter<W> {
    output: W,
    header: OutputHeader,
    grid: ChunkGrid,
    encoder: ChunkEncoder,
    /// Where each chunk begins; 0 before it is written.
    offsets: Vec<u64>,
    length: u64,
    max_samples: u32,
    /// Rows of a band that is not yet whole, and the next row to come.
    pending: DeepRows,
    next_row: u32,
}

impl<W: Write + Seek> DeepExrWriter<W> {
    /// Starts an image at the start of `output`, which is empty.
    ///
    /// # Errors
    ///
    /// [`Error::Options`] if no OpenEXR file can be this image;
    /// [`Error::Write`] if the output fails.
    pub fn new(output: W, options: &WriteOptions) -> Result<Self> {
        let grid = options.grid()?;
        let count = usize::try_from(grid.count()).unwrap_or(usize::MAX);
        let mut writer = Self {
            output,
            header: OutputHeader::new(options)?,
            grid,
            encoder: ChunkEncoder::new(options),
            offsets: vec![0; count],
            length: 0,
            max_samples: 0,
            pending: options.rows(grid.width()),
            next_row: 0,
        };
        // The fullest pixel and the chunks' places are known at the end.
        let start = writer.start();
        writer.append(&start)?;
        Ok(writer)
    }

    /// Header and offset table.
    fn start(&self) -> Vec<u8> {
        let mut bytes = self.header.bytes(self.max_samples);
        bytes.extend(self.offsets.iter().flat_map(|offset| offset.to_le_bytes()));
        bytes
    }

    fn append(&mut self, bytes: &[u8]) -> Result<()> {
        self.output.write_all(bytes).map_err(Error::Write)?;
        self.length += bytes.len() as u64;
        Ok(())
    }

    /// Grid of the image's chunks.
    pub fn grid(&self) -> ChunkGrid {
        self.grid
    }

    /// The number of samples of the fullest pixel so far.
    pub fn max_samples(&self) -> u32 {
        self.max_samples
    }

    /// Appends the next whole pixel rows, from the top of the data window on.
    ///
    /// # Errors
    ///
    /// [`Error::Rows`] if they are not as wide as the image, more than are left,
    /// or without its columns; [`Error::Write`] if the output fails.
    pub fn write_rows(&mut self, rows: &DeepRows) -> Result<()> {
        let fail = |reason| {
            let place = format!("{} rows from row {} on", rows.rows(), self.next_row);
            Err(Error::Rows { place, reason })
        };
        if let Some(reason) = self.encoder.misfit(rows) {
            return fail(reason);
        }
        if rows.width() != self.grid.width() {
            return fail("the image has another width");
        }
        if rows.rows() > self.grid.height() - self.next_row {
            return fail("the image has fewer rows");
        }
        let mut first = 0;
        while first < rows.rows() {
            let band = self.grid.band_of(self.next_row);
            let lines = self.grid.rows(band);
            let end = rows.rows().min(first + (lines.end - self.next_row));
            if end - first == lines.len() as u32 {
                self.write_band(band, rows, first)?;
            } else {
                self.pending.append(rows, first..end)?;
                if self.pending.rows() == lines.len() as u32 {
                    let none = self.encoder.rows(self.grid.width());
                    let whole = std::mem::replace(&mut self.pending, none);
                    self.write_band(band, &whole, 0)?;
                }
            }
            self.next_row += end - first;
            first = end;
        }
        Ok(())
    }

    /// Writes a row of blocks; its pixels begin at the row `first` of `rows`.
    fn write_band(&mut self, band: u32, rows: &DeepRows, first: u32) -> Result<()> {
        for column in 0..self.grid.columns() {
            let block = self.grid.block(column, band);
            let (columns, lines) = (block.x..block.x + block.width, first..first + block.height);
            let chunk = self.encoder.encode_part(rows, columns, lines)?;
            self.write_chunk(&block, &chunk)?;
        }
        Ok(())
    }

    /// Appends the chunk of a block of the [`grid`](Self::grid). Blocks may come
    /// in any order; that of the grid is the fastest to read.
    ///
    /// # Errors
    ///
    /// [`Error::Rows`] if the chunk is not of the block's size, or the block was
    /// written before; [`Error::Write`] if the output fails.
    pub fn write_chunk(&mut self, block: &Block, chunk: &EncodedChunk) -> Result<()> {
        let EncodedChunk { size, table, samples, unpacked_samples, max_samples } = chunk;
        let fail = |reason| Err(Error::Rows { place: self.grid.describe(block), reason });
        if *size != [block.width, block.height] {
            return fail("the chunk is of another size");
        }
        match self.offsets.get_mut(self.grid.index(block)) {
            Some(offset @ 0) => *offset = self.length,
            Some(_) => return fail("it was written before"),
            None => return fail("the image has no such block"),
        }
        let (coordinates, count) = self.grid.coordinates(block);
        let mut start: Vec<u8> =
            coordinates[..count].iter().flat_map(|number| number.to_le_bytes()).collect();
        for size in [table.len() as u64, samples.len() as u64, *unpacked_samples] {
            start.extend(size.to_le_bytes());
        }
        self.max_samples = self.max_samples.max(*max_samples);
        [&start, table, samples].iter().try_for_each(|bytes| self.append(bytes))
    }

    /// Writes the header and the chunks' places, and gives the output back,
    /// flushed.
    ///
    /// # Errors
    ///
    /// [`Error::Incomplete`] if a chunk was not written; [`Error::Write`] if the
    /// output fails.
    pub fn finish(mut self) -> Result<W> {
        let mut missing = (0..).zip(&self.offsets).filter(|(_, offset)| **offset == 0);
        if let Some((first, _)) = missing.next() {
            let missing = 1 + missing.count() as u64;
            let (column, band) = (first % self.grid.columns(), first / self.grid.columns());
            let first = self.grid.describe(&self.grid.block(column, band));
            return Err(Error::Incomplete { missing, first });
        }
        let start = self.start();
        let written = self
            .output
            .seek(SeekFrom::Start(0))
            .and_then(|_| self.output.write_all(&start))
            .and_then(|()| self.output.flush());
        written.map(|()| self.output).map_err(Error::Write)
    }
}

impl<W> fmt::Debug for DeepExrWriter<W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("DeepExrWriter").field("grid", &self.grid).finish_non_exhaustive()
    }
}
