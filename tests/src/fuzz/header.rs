//! A whole file, under right checksums.

use super::read_everything;
use crate::forge::Forge;

/// Signs `bytes` as far as their offsets lead anywhere, and reads everything:
/// prologue, sections, metadata, levels, directories and tiles.
///
/// # Panics
///
/// If the reader contradicts itself.
pub fn header(bytes: &[u8]) -> bool {
    read_everything(bytes.to_vec()) | read_everything(Forge(bytes.to_vec()).sign())
}
