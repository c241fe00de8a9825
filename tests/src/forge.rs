//! Changes files and signs them again, after `docs/format/dsm-1.md` and
//! without the library: what stands behind the checksums must hold as well.

#![expect(clippy::unwrap_used, reason = "only test programs forge files")]

/// CRC-32C, after the document's definition.
#[must_use]
pub fn crc32c(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0_u32, |crc, &byte| (crc >> 8) ^ REMAINDERS[usize::from(crc as u8 ^ byte)])
}

/// What every byte leaves behind.
const REMAINDERS: [u32; 256] = {
    let mut remainders = [0; 256];
    let mut byte = 0;
    while byte < 256 {
        let (mut crc, mut bit) = (byte as u32, 0);
        while bit < 8 {
            crc = (crc >> 1) ^ if crc & 1 == 1 { 0x82f6_3b78 } else { 0 };
            bit += 1;
        }
        remainders[byte] = crc;
        byte += 1;
    }
    remainders
};

/// A file to change.
#[derive(Clone, Debug)]
pub struct Forge(pub Vec<u8>);

impl Forge {
    /// The number at an offset.
    #[must_use]
    pub fn u32(&self, at: usize) -> u32 {
        u32::from_le_bytes(self.0[at..at + 4].try_into().unwrap())
    }

    /// The number at an offset.
    #[must_use]
    pub fn u64(&self, at: usize) -> u64 {
        u64::from_le_bytes(self.0[at..at + 8].try_into().unwrap())
    }

    /// Overwrites what stands at an offset.
    pub fn put<const N: usize>(&mut self, at: usize, bytes: [u8; N]) {
        self.0[at..at + N].copy_from_slice(&bytes);
    }

    /// Where the entry of the first section of this kind stands.
    #[must_use]
    pub fn section_entry(&self, kind: &[u8; 4]) -> usize {
        let table = self.u64(24) as usize;
        let mut entries = (0..self.u32(32) as usize).map(|index| table + 32 * index);
        entries.find(|&entry| &self.0[entry..entry + 4] == kind).unwrap()
    }

    /// Where the first section of this kind stands.
    #[must_use]
    pub fn section(&self, kind: &[u8; 4]) -> usize {
        self.u64(self.section_entry(kind) + 8) as usize
    }

    /// Where the directory entry of the first level's tile `index` stands.
    #[must_use]
    pub fn tile_entry(&self, index: usize) -> usize {
        self.section(b"TDIR") + 64 * index
    }

    /// Where the payload of that tile stands.
    #[must_use]
    pub fn payload(&self, index: usize) -> usize {
        self.u64(self.tile_entry(index)) as usize
    }

    /// Replaces the first occurrence of `from` in the metadata.
    pub fn replace(&mut self, from: &str, to: &str) {
        assert_eq!(from.len(), to.len());
        let start = self.section(b"META");
        let position =
            self.0[start..].windows(from.len()).position(|bytes| bytes == from.as_bytes()).unwrap();
        self.0[start + position..][..to.len()].copy_from_slice(to.as_bytes());
    }

    /// Computes every checksum anew, as far as the offsets lead anywhere.
    #[must_use]
    pub fn sign(mut self) -> Vec<u8> {
        if self.0.len() < 64 {
            return self.0;
        }
        let (table, count) = (self.u64(24), u64::from(self.u32(32)));
        for entry in (0..count).map(|index| table.saturating_add(32 * index)) {
            if entry.saturating_add(32) > self.0.len() as u64 {
                break;
            }
            let entry = entry as usize;
            let (offset, length) = (self.u64(entry + 8), self.u64(entry + 16));
            if &self.0[entry..entry + 4] == b"TDIR" && self.block(offset, length).is_some() {
                for tile in (0..length as usize / 64).map(|tile| offset as usize + 64 * tile) {
                    let (start, stored) = (self.u64(tile), self.u64(tile + 8));
                    if let (1.., Some(crc)) = (start, self.block(start, stored)) {
                        self.put(tile + 52, crc.to_le_bytes());
                    }
                }
            }
            if let Some(crc) = self.block(offset, length) {
                self.put(entry + 24, crc.to_le_bytes());
            }
        }
        if let Some(crc) = self.block(table, count * 32) {
            self.put(36, crc.to_le_bytes());
        }
        let crc = crc32c(&self.0[..60]);
        self.put(60, crc.to_le_bytes());
        self.0
    }

    /// The checksum of a run of bytes and its padding, if it lies in the file.
    fn block(&self, offset: u64, length: u64) -> Option<u32> {
        let end = offset.checked_add(length)?.checked_next_multiple_of(64)?;
        self.0.get(usize::try_from(offset).ok()?..usize::try_from(end).ok()?).map(crc32c)
    }
}

#[cfg(test)]
#[test]
fn the_checksum_is_the_published_one() {
    assert_eq!(crc32c(b"123456789"), 0xe306_9283);
}

/// The parts of a file, to be put together and signed.
#[derive(Clone, Debug)]
pub struct Assembly {
    metadata: Vec<u8>,
    /// Payloads of tiles: the first stands at offset 64, each next where the
    /// one before, padded, ends.
    pub payloads: Vec<Vec<u8>>,
    /// A record of 64 bytes for each level, and its tile directory.
    pub levels: Vec<(Vec<u8>, Vec<u8>)>,
}

impl Assembly {
    /// Metadata as JSON; no tiles and no levels.
    #[must_use]
    pub fn new(metadata: &str) -> Self {
        let metadata = metadata.as_bytes().to_vec();
        Self { metadata, payloads: Vec::new(), levels: Vec::new() }
    }

    /// The record of a level 0 with square tiles and no error.
    #[must_use]
    pub fn level(width: u32, height: u32, tile_size: u32) -> Vec<u8> {
        [0, 0, width, height, 0, 0, tile_size, tile_size, 0, 0, 0, 0, 0, 0, 0, 0]
            .into_iter()
            .flat_map(u32::to_le_bytes)
            .collect()
    }

    /// The file, with section numbers, lengths and checksums as they must be.
    #[must_use]
    pub fn bytes(self) -> Vec<u8> {
        let mut bytes = vec![0; 64];
        for payload in self.payloads {
            append(&mut bytes, &payload);
        }
        let mut sections = vec![(b"META", append(&mut bytes, &self.metadata))];
        let mut records = Vec::new();
        for (mut record, directory) in self.levels {
            record[44..48].copy_from_slice(&(sections.len() as u32).to_le_bytes());
            records.extend(record);
            sections.push((b"TDIR", append(&mut bytes, &directory)));
        }
        sections.push((b"LEVL", append(&mut bytes, &records)));
        let mut table = Vec::new();
        for (kind, [offset, length]) in &sections {
            table.extend_from_slice(*kind);
            table.extend(1_u32.to_le_bytes());
            table.extend([*offset, *length].into_iter().flat_map(u64::to_le_bytes));
            table.extend([0; 8]);
        }
        let [offset, _] = append(&mut bytes, &table);
        let mut forge = Forge(bytes);
        forge.put(0, *b"\x89DSM\r\n\x1a\n");
        forge.put(8, 1_u16.to_le_bytes());
        forge.put(16, (forge.0.len() as u64).to_le_bytes());
        forge.put(24, offset.to_le_bytes());
        forge.put(32, (sections.len() as u32).to_le_bytes());
        forge.sign()
    }
}

/// Appends an extent with its padding; where it stands and its length.
fn append(bytes: &mut Vec<u8>, extent: &[u8]) -> [u64; 2] {
    let offset = bytes.len() as u64;
    bytes.extend_from_slice(extent);
    bytes.resize(bytes.len().next_multiple_of(64), 0);
    [offset, extent.len() as u64]
}
