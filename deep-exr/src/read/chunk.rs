//! Finding the chunks of a part.

use super::part::FileParts;
use super::readable_part::ReadablePart;
use super::scan::ChunkScan;
use super::source::ByteSource;
use crate::error::{Error, Result};
use crate::grid::Block;
use crate::limits::Limits;

/// A part's chunks, by its offset table.
pub(super) struct ChunkTable {
    offsets: Vec<u64>,
    found: u64,
}

impl ChunkTable {
    /// Reads the entries of the largest level, which come first. Where some are no
    /// places of chunks, as in a file that was not written to its end, the file is
    /// looked through for them.
    pub(super) fn read(
        source: &mut ByteSource,
        file: &FileParts,
        part: &ReadablePart,
    ) -> Result<Self> {
        let bytes = source.slice(part.table_offset, 8 * part.grid.count(), "offset table")?;
        let (entries, _) = bytes.as_chunks::<8>();
        let mut offsets: Vec<_> = entries.iter().map(|&entry| u64::from_le_bytes(entry)).collect();
        let chunks = part.chunks_offset..source.length();
        let is_lost = |offset: u64| !chunks.contains(&offset);
        let mut found = 0;
        if offsets.iter().any(|&offset| is_lost(offset)) {
            ChunkScan::new(source, file, part).each(|index, offset| {
                if let Some(entry) = offsets.get_mut(index).filter(|entry| is_lost(**entry)) {
                    *entry = offset;
                    found += 1;
                }
            })?;
        }
        Ok(Self { offsets, found })
    }

    /// How many chunks were not found by the file's own table.
    pub(super) fn found(&self) -> u64 {
        self.found
    }

    /// Where the chunk of this block begins, after its coordinates are
    /// compared with the block's; and the offset of what follows them.
    pub(super) fn locate(
        &self,
        source: &mut ByteSource,
        part: &ReadablePart,
        block: &Block,
    ) -> Result<ChunkStart> {
        let grid = &part.grid;
        let offset = self.offsets.get(grid.index(block)).copied().unwrap_or(0);
        let place = ChunkPlace { part, block, offset };
        if offset == 0 {
            return Err(place.error("missing: the file was not written to its end"));
        }
        if offset < part.chunks_offset {
            return Err(place.error("the offset points into the header"));
        }
        let (coordinates, count) = grid.coordinates(block);
        let has_part = part.chunk_part.is_some();
        let length = 4 * (count + usize::from(has_part)) as u64;
        if offset > source.length() || source.length() - offset < length {
            return Err(place.error(format!("beyond the file's {} bytes", source.length())));
        }
        let bytes = source.slice(offset, length, "chunk")?;
        let mut numbers = bytes.as_chunks::<4>().0.iter().map(|&word| i32::from_le_bytes(word));
        if let Some(expected) = part.chunk_part {
            let found = numbers.next();
            if found != Some(expected) {
                return Err(place.error(format!("belongs to part {}", found.unwrap_or(-1))));
            }
        }
        if !numbers.clone().eq(coordinates[..count].iter().copied()) {
            let found: Vec<_> = numbers.collect();
            let what = if grid.is_tiled() { "tile and level" } else { "scan line" };
            return Err(place.error(format!("the chunk there is {what} {found:?}")));
        }
        Ok(ChunkStart { offset, data_offset: offset + length })
    }
}

/// Where a chunk, and what follows its coordinates, begins.
#[derive(Clone, Copy, Debug)]
pub(super) struct ChunkStart {
    pub(super) offset: u64,
    pub(super) data_offset: u64,
}

/// Where the two packed pieces of a chunk stand, and how long they are.
#[derive(Clone, Copy, Debug)]
pub(super) struct DeepChunk {
    pub(super) block: Block,
    pub(super) offset: u64,
    pub(super) table_offset: u64,
    pub(super) packed_table: u64,
    pub(super) packed_samples: u64,
    pub(super) unpacked_samples: u64,
}

/// A chunk, for messages.
pub(super) struct ChunkPlace<'a> {
    pub(super) part: &'a ReadablePart,
    pub(super) block: &'a Block,
    pub(super) offset: u64,
}

impl ChunkPlace<'_> {
    pub(super) fn error(&self, reason: impl Into<String>) -> Error {
        Error::Chunk {
            place: self.part.grid.describe(self.block),
            offset: self.offset,
            reason: reason.into(),
        }
    }

    /// Compares a size in bytes with the limit.
    pub(super) fn check_size(&self, what: &'static str, bytes: u64, limits: &Limits) -> Result<()> {
        if bytes <= limits.max_chunk_bytes {
            return Ok(());
        }
        Err(Error::LimitExceeded {
            place: format!("{} (offset {})", self.part.grid.describe(self.block), self.offset),
            what,
            value: bytes,
            limit: limits.max_chunk_bytes,
        })
    }
}
