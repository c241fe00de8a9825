//! Attenuation maps into files.

use std::path::Path;

use dsm_core::{MapInfo, Transmittance};
use dsm_io::detail::{BakeReport, EncodedTile, KindWriter, Result, TileId};
use dsm_io::{AchievedError, Metadata, WriteOptions};
use rayon::prelude::*;

use super::builder::AttenuationBuilder;
use super::keys::AttenuationKeys;
use super::store::Attenuation;
use crate::prefilter::store::encode;

/// Writes the map of all views so far into a file that replaces `output`, if there is one,
/// in tiles as `options` say. `describe` may add to what the map says of itself, such as
/// its light. Holds the map.
///
/// # Errors
///
/// What keeps the file from being written.
pub fn write_attenuation<T: Transmittance>(
    builder: &AttenuationBuilder<T>,
    output: &Path,
    options: WriteOptions,
    describe: impl FnOnce(&mut Metadata),
) -> Result<BakeReport> {
    let (lists, counts) = builder.finish()?;
    let [width, height] = builder.frame().size();
    let info = MapInfo::new().with_camera(*builder.camera()).with_samples(1);
    let mut metadata = Metadata::new(width, height, T::CHANNELS as u8, info);
    describe(&mut metadata);
    let keys = AttenuationKeys {
        light_samples: builder.views(),
        depth_tolerance: builder.tolerance() as f32,
    };
    let mut writer = KindWriter::<Attenuation>::create(output, metadata, &keys, options)?;
    let level = writer.levels()[0];
    let [columns, rows] = level.tiles();
    for y in 0..rows {
        let encoded = |x: u32| -> Result<EncodedTile> {
            let Some(rect) = level.tile_rect(x, y) else { return Ok(EncodedTile::default()) };
            encode(&lists.part(rect.x, rect.y, [rect.width, rect.height])?, options.packing)
        };
        let tiles: Vec<_> = (0..columns).into_par_iter().map(encoded).collect();
        for (x, tile) in (0..columns).zip(tiles) {
            writer.write_encoded(TileId::new(0, x, y), &tile?, AchievedError::NONE)?;
        }
    }
    let bytes = writer.finish()?;
    Ok(BakeReport { hits: counts.hits, bytes, ..BakeReport::default() })
}
