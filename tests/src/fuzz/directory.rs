//! Levels and tile directories, in a file that is otherwise sound.

use super::read_everything;
use crate::forge::{Assembly, Forge};

/// Takes `bytes` for the levels and directories of a file: the first byte
/// tells how many levels (1 to 4), the second the channels; then a record of
/// 64 bytes a level; the rest is shared out among the directories. Two tiles
/// lie in the file for them to point at.
///
/// # Panics
///
/// If the reader contradicts itself.
pub fn directory(bytes: &[u8]) -> bool {
    let Some((&[levels, channels], rest)) = bytes.split_first_chunk() else { return false };
    let count = 1 + usize::from(levels % 4);
    let channels = if channels % 2 == 0 { 1 } else { 3 };
    if rest.len() < 64 * count {
        return false;
    }
    let (records, entries) = rest.split_at(64 * count);
    let first = Forge(records.to_vec());
    let (width, height) = (first.u32(8), first.u32(12));
    let tolerance = f32::from_bits(first.u32(32));
    let tolerance = if (0.0..1.0).contains(&tolerance) { tolerance } else { 0.0 };
    let share = (entries.len() / 64).div_ceil(count).max(1) * 64;
    let mut assembly = Assembly::new(&format!(
        r#"{{"kind":"deep","width":{width},"height":{height},"channels":{channels},"depth_kind":"planar","tolerance":{tolerance:e}}}"#
    ));
    assembly.payloads.extend([step(channels), step(channels)]);
    let mut directories = entries.chunks(share);
    for record in records.chunks(64) {
        let mut entries = directories.next().unwrap_or_default().to_vec();
        entries.truncate(entries.len() / 64 * 64);
        assembly.levels.push((record.to_vec(), entries));
    }
    read_everything(assembly.bytes())
}

/// The payload of a plain tile of one pixel, a step at 2 to ¼.
fn step(channels: usize) -> Vec<u8> {
    let values: &[f32] =
        if channels == 1 { &[1.0, 0.25] } else { &[1.0, 0.25, 1.0, 0.5, 1.0, 0.0] };
    let tables: &[u32] = if channels == 1 { &[0, 2] } else { &[0, 2, 0, 6, 0] };
    let depths = [2.0_f32, 2.0];
    let floats = depths.iter().chain(values).map(|value| value.to_bits());
    tables.iter().copied().chain(floats).flat_map(u32::to_le_bytes).collect()
}
