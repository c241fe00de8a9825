//! What a stored map shows through the middle of every pixel.

use dsm_core::{Rgb, Transmittance};
use dsm_io::detail::{Deep, KindReader, TileRect};
use mtsm::detail::Layers;
use shadow_maps::detail::{CollectedHits, Fragments};

use crate::error::Result;

/// Hits of all pixels, with as many channels as the map has.
pub(crate) enum TexelHits {
    Mono(CollectedHits<f32>),
    Rgb(CollectedHits<Rgb>),
}

/// The part of a pixel of 8 × 8 whose coverage stands for its middle, and where that is
/// from there: the middle itself is a corner.
const MIDDLE: (u32, f32) = (8 * 4 + 4, 0.5 / 8.0);

/// The hits of a map of fragments: the planes of those that cover the middle.
pub(crate) fn of_fragments<T: Transmittance>(
    reader: &KindReader<Fragments>,
) -> Result<CollectedHits<T>> {
    let metadata = reader.metadata();
    let mut hits = CollectedHits::new([metadata.width, metadata.height]);
    let (bit, off) = MIDDLE;
    reader.for_each_pixel::<T>(0, |tile, pixel| {
        let met = tile.fragments(pixel).filter(|fragment| fragment.coverage >> bit & 1 == 1);
        let hit = met.map(|fragment| {
            let [right, down] = fragment.gradient.unwrap_or_default();
            (fragment.w + off * (right + down), fragment.opacity)
        });
        Ok(hits.push_texel(hit)?)
    })?;
    Ok(hits)
}

/// The hits of a map of layers: they are stored.
pub(crate) fn of_layers<T: Transmittance>(reader: &KindReader<Layers>) -> Result<CollectedHits<T>> {
    let metadata = reader.metadata();
    let mut hits = CollectedHits::new([metadata.width, metadata.height]);
    reader.for_each_pixel::<T>(0, |tile, pixel| {
        let layers = tile.layers(pixel).filter(|layer| layer.depth > 0.0);
        let hit = layers.map(|layer| (layer.depth.recip().min(f32::MAX), layer.opacity));
        Ok(hits.push_texel(hit)?)
    })?;
    Ok(hits)
}

/// The hits of a deep map: what each step, or each stretch between two vertices, takes of
/// the light that is left there. A stretch is one hit, in its middle.
pub(crate) fn of_functions<T: Transmittance>(
    reader: &KindReader<Deep>,
) -> Result<CollectedHits<T>> {
    let level = reader.levels()[0];
    let [width, height] = [level.width, level.height];
    let mut hits = CollectedHits::new([width, height]);
    let rows = level.tile_height.min(height);
    for y in (0..height).step_by(rows as usize) {
        let rect = TileRect { x: 0, y, width, height: rows.min(height - y) };
        let functions = reader.functions::<T>(0, rect)?;
        for function in functions.pixels().view().functions() {
            let vertices: Vec<_> = function.vertices().collect();
            let hit = vertices.windows(2).filter_map(|pair| {
                let depth = (pair[0].z + pair[1].z) / 2.0;
                let opacity = T::from_channels(|channel| {
                    let [before, after] = [0, 1].map(|end| pair[end].value.channel(channel));
                    if before > 0.0 { ((before - after) / before).clamp(0.0, 1.0) } else { 0.0 }
                });
                (depth > 0.0).then(|| (depth.recip().min(f32::MAX), opacity))
            });
            hits.push_texel(hit)?;
        }
    }
    Ok(hits)
}
