//! How large plain shadow maps are.

use anyhow::Result;
use rayon::prelude::*;
use shadow_maps::plain::DepthMap;

/// Bytes a depth of the paper's normal shadow maps: 341.34 MB of 16384².
pub(super) const PAPER_BYTES: f64 = 4.0 / 3.0;

/// Depths that are packed together, as a tile of the map is.
const CHUNK: usize = 1 << 20;

/// Length of the map's depths as `f32`, their bytes sorted by significance, in
/// zstd frames: as the tiles of a deep map are packed, at a level that packs
/// better.
///
/// # Errors
///
/// What zstd says.
pub(super) fn packed_depths(map: &DepthMap) -> Result<u64> {
    let lengths = map.depths().par_chunks(CHUNK).map(|depths| {
        let plane = |byte: usize| depths.iter().map(move |depth| depth.to_le_bytes()[byte]);
        let planes: Vec<u8> = (0..4).flat_map(plane).collect();
        Ok(zstd::bulk::compress(&planes, 3)?.len() as u64)
    });
    lengths.sum()
}
