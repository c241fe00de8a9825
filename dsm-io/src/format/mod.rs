//! The container: where everything stands in a `.dsm` file of version 1.
//!
//! `docs/format/dsm-1.md` is normative; this folder alone knows offsets. The
//! container knows sections, levels and tiles, not what a tile means: that is
//! its codec's business, and the metadata's kind names who knows it.

pub(crate) mod atomic_file;
pub(crate) mod container;
pub(crate) mod directory;
pub(crate) mod encoded_tile;
mod extent;
pub(crate) mod level;
mod prologue;
pub(crate) mod section;
pub(crate) mod version;
pub(crate) mod write;

/// The `N` bytes of a record that begin at `at`; the caller knows they fit.
fn field<const N: usize>(record: &[u8], at: usize) -> [u8; N] {
    std::array::from_fn(|index| record[at + index])
}

fn u32_at(record: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(field(record, at))
}

fn u64_at(record: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(field(record, at))
}

fn f32_at(record: &[u8], at: usize) -> f32 {
    f32::from_le_bytes(field(record, at))
}

fn put<const N: usize>(record: &mut [u8], at: usize, bytes: [u8; N]) {
    record[at..at + N].copy_from_slice(&bytes);
}

/// Whether reserved bytes keep to the rule of minor version 0: zero. What a
/// later minor version puts there, this program does not need.
fn reserved_is_valid(bytes: &[u8], minor: u16) -> bool {
    minor > version::MINOR || bytes.iter().all(|&byte| byte == 0)
}
