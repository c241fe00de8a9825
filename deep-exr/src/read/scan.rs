//! Looking through a file for chunks that its offset table does not name.

use super::part::{FileParts, PartType};
use super::readable_part::ReadablePart;
use super::source::ByteSource;
use crate::error::Result;

/// Walk from chunk to chunk by their own sizes, from where the first begins to what
/// is none.
pub(super) struct ChunkScan<'a> {
    source: &'a mut ByteSource,
    file: &'a FileParts,
    part: &'a ReadablePart,
}

/// A chunk's place, what its coordinates are, and where the next one begins.
struct Found {
    coordinates: Option<[i32; 4]>,
    end: u64,
}

impl<'a> ChunkScan<'a> {
    pub(super) fn new(
        source: &'a mut ByteSource,
        file: &'a FileParts,
        part: &'a ReadablePart,
    ) -> Self {
        Self { source, file, part }
    }

    /// Tells `found` the index in the offset table and the place of every chunk of
    /// the part, in the file's order. Every step is longer than 0: there are no more
    /// than the file has bytes.
    pub(super) fn each(mut self, mut found: impl FnMut(usize, u64)) -> Result<()> {
        let mut offset = self.part.chunks_offset;
        while let Some(chunk) = self.chunk(offset)? {
            let index = chunk.coordinates.and_then(|numbers| self.part.grid.index_of(numbers));
            if let Some(index) = index {
                found(index, offset);
            }
            offset = chunk.end;
        }
        Ok(())
    }

    /// The chunk that begins here and is whole; coordinates of this part's only.
    fn chunk(&mut self, offset: u64) -> Result<Option<Found>> {
        let mut position = offset;
        let index = match self.part.chunk_part {
            None => Some(0),
            Some(_) => self.number(&mut position)?.and_then(|part| usize::try_from(part).ok()),
        };
        let Some(part) = index.and_then(|index| self.file.parts.get(index)) else {
            return Ok(None);
        };
        let (is_deep, is_tiled) = match part.part_type {
            PartType::Deep { tiled } => (true, tiled),
            PartType::Flat { tiled } => (false, tiled),
            PartType::Other(_) => return Ok(None),
        };
        let mut numbers = [0; 4];
        for number in &mut numbers[..if is_tiled { 4 } else { 1 }] {
            let Some(read) = self.number(&mut position)? else { return Ok(None) };
            *number = read;
        }
        let length = if is_deep {
            let sizes = [self.size(&mut position)?, self.size(&mut position)?];
            // The third one is what the samples unpack to.
            let unpacked = self.size(&mut position)?;
            let packed = sizes[0].zip(sizes[1]).and_then(|(table, own)| table.checked_add(own));
            packed.filter(|_| unpacked.is_some())
        } else {
            self.number(&mut position)?.and_then(|size| u64::try_from(size).ok())
        };
        let end = length.and_then(|length| position.checked_add(length));
        let is_own = self.part.chunk_part.is_none_or(|own| index == usize::try_from(own).ok());
        Ok(end
            .filter(|&end| end <= self.source.length())
            .map(|end| Found { coordinates: is_own.then_some(numbers), end }))
    }

    fn number(&mut self, position: &mut u64) -> Result<Option<i32>> {
        Ok(self.bytes(position)?.map(i32::from_le_bytes))
    }

    fn size(&mut self, position: &mut u64) -> Result<Option<u64>> {
        Ok(self.bytes(position)?.map(u64::from_le_bytes))
    }

    /// The next `N` bytes, unless the file ends before.
    fn bytes<const N: usize>(&mut self, position: &mut u64) -> Result<Option<[u8; N]>> {
        let start = *position;
        if start.checked_add(N as u64).is_none_or(|end| end > self.source.length()) {
            return Ok(None);
        }
        *position += N as u64;
        let bytes = self.source.slice(start, N as u64, "chunk")?;
        Ok(bytes.first_chunk::<N>().copied())
    }
}
