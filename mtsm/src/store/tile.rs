//! Helpers for the tiles of both kinds.

use dsm_core::Transmittance;
use dsm_io::MapSummary;
use dsm_io::detail::{MapKind, MapTiles, Result};
use dsm_trace::detail::MinMaxBuilder;

use crate::layers_of_pixel::PixelLayers;

/// The smallest and the largest of the depths of pixels or runs, each sorted.
pub(super) fn range_of(ranges: impl Iterator<Item = [f32; 2]>) -> [f32; 2] {
    let range = ranges.fold([f32::INFINITY, 0.0_f32], |[low, high], [first, last]| {
        [low.min(first), high.max(last)]
    });
    range.map(|z| z + 0.0)
}

/// Bytes of a column.
pub(super) const fn bytes<V>(column: &[V]) -> u64 {
    size_of_val(column) as u64
}

/// What all tiles of the finest level hold together, and how many nodes of each
/// level of the tree of depths that tracers walk are empty. Holds one tile, and 8
/// bytes a pixel.
pub(super) fn summary<K, T>(map: &impl MapTiles<Tile = K::Tile<T>>) -> Result<MapSummary>
where
    K: MapKind,
    T: Transmittance,
    K::Tile<T>: PixelLayers<T>,
{
    let mut summary = MapSummary::default();
    let metadata = map.metadata();
    let mut ranges = MinMaxBuilder::new([metadata.width, metadata.height])?;
    map.for_each_tile(|rect, tile| {
        K::summarize(&tile, &mut summary);
        for pixel in 0..rect.width * rect.height {
            if let Some(depths) = tile.depth_range(pixel as usize) {
                let at = [rect.x + pixel % rect.width, rect.y + pixel / rect.width];
                ranges.set_depths(at, depths, 0.0);
            }
        }
        Ok(())
    })?;
    let pyramid = ranges.finish();
    let empty = (0..pyramid.level_count()).map(|level| pyramid.empty_nodes(level));
    summary.set_counts("empty_nodes", empty.collect());
    Ok(summary)
}
