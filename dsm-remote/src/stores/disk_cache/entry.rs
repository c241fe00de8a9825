//! A range in the cache: its file's name and bytes.

use std::ops::Range;

use crc_fast::{CrcAlgorithm, checksum};

/// What an entry begins with.
const MAGIC: [u8; 8] = *b"DSMRNGE1";
/// Bytes of the checksum at its end.
const CHECKSUM_BYTES: u64 = 8;

/// What identifies a range: of which version of which file, and where.
#[derive(Debug)]
pub(super) struct Entry {
    /// All of it, which the file begins with.
    head: Vec<u8>,
    length: u64,
}

impl Entry {
    pub(super) fn new(key: &str, range: &Range<u64>) -> Self {
        let mut head = MAGIC.to_vec();
        head.extend(range.start.to_le_bytes());
        head.extend(range.end.to_le_bytes());
        head.extend((key.len() as u64).to_le_bytes());
        head.extend(key.as_bytes());
        Self { head, length: range.end - range.start }
    }

    /// The name of its file. Two entries of one name take each other's place: what a file
    /// begins with tells whose it is.
    pub(super) fn name(&self) -> String {
        format!("{:016x}", checksum(CrcAlgorithm::Crc64Nvme, &self.head))
    }

    /// Bytes of its file.
    pub(super) const fn stored_length(&self) -> u64 {
        self.head.len() as u64 + self.length + CHECKSUM_BYTES
    }

    /// Its file, with the range's bytes.
    pub(super) fn encode(&self, bytes: &[u8]) -> Vec<u8> {
        let mut stored = [&self.head, bytes].concat();
        stored.extend(checksum(CrcAlgorithm::Crc64Nvme, &stored).to_le_bytes());
        stored
    }

    /// The range's bytes, if a file is whole and this entry's.
    pub(super) fn decode(&self, mut stored: Vec<u8>) -> Option<Vec<u8>> {
        if stored.len() as u64 != self.stored_length() || !stored.starts_with(&self.head) {
            return None;
        }
        let (rest, sum) = stored.split_last_chunk::<{ CHECKSUM_BYTES as usize }>()?;
        if checksum(CrcAlgorithm::Crc64Nvme, rest).to_le_bytes() != *sum {
            return None;
        }
        stored.truncate(rest.len());
        stored.drain(..self.head.len());
        Some(stored)
    }
}
