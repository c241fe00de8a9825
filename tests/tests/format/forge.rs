//! Changes files and signs them again, after `docs/format/dsm-1.md` and
//! without the library: what stands behind the checksums must hold as well.

/// CRC-32C, bit by bit: the document's definition.
pub(crate) fn crc32c(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0_u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| {
            (crc >> 1) ^ if crc & 1 == 1 { 0x82f6_3b78 } else { 0 }
        })
    })
}

/// A file to change.
#[derive(Clone)]
pub(crate) struct Forge(pub(crate) Vec<u8>);

impl Forge {
    pub(crate) fn u32(&self, at: usize) -> u32 {
        u32::from_le_bytes(self.0[at..at + 4].try_into().unwrap())
    }

    pub(crate) fn u64(&self, at: usize) -> u64 {
        u64::from_le_bytes(self.0[at..at + 8].try_into().unwrap())
    }

    pub(crate) fn put<const N: usize>(&mut self, at: usize, bytes: [u8; N]) {
        self.0[at..at + N].copy_from_slice(&bytes);
    }

    /// Where the entry of the first section of this kind stands.
    pub(crate) fn section_entry(&self, kind: &[u8; 4]) -> usize {
        let table = self.u64(24) as usize;
        let mut entries = (0..self.u32(32) as usize).map(|index| table + 32 * index);
        entries.find(|&entry| &self.0[entry..entry + 4] == kind).unwrap()
    }

    /// Where the first section of this kind stands.
    pub(crate) fn section(&self, kind: &[u8; 4]) -> usize {
        self.u64(self.section_entry(kind) + 8) as usize
    }

    /// Where the directory entry of the first level's tile `index` stands.
    pub(crate) fn tile_entry(&self, index: usize) -> usize {
        self.section(b"TDIR") + 64 * index
    }

    /// Where the payload of that tile stands.
    pub(crate) fn payload(&self, index: usize) -> usize {
        self.u64(self.tile_entry(index)) as usize
    }

    /// Replaces the first occurrence of `from` in the metadata.
    pub(crate) fn replace(&mut self, from: &str, to: &str) {
        assert_eq!(from.len(), to.len());
        let start = self.section(b"META");
        let position =
            self.0[start..].windows(from.len()).position(|bytes| bytes == from.as_bytes()).unwrap();
        self.0[start + position..][..to.len()].copy_from_slice(to.as_bytes());
    }

    /// Computes every checksum anew, as far as the offsets lead anywhere.
    pub(crate) fn sign(mut self) -> Vec<u8> {
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

#[test]
fn the_checksum_is_the_published_one() {
    assert_eq!(crc32c(b"123456789"), 0xe306_9283);
}

#[test]
fn signing_an_unchanged_file_changes_nothing() {
    let bytes = crate::examples::coloured(dsm_io::Block::Plain).bytes();
    assert!(Forge(bytes.clone()).sign() == bytes);
}
