//! Bakes of prefiltered maps into files.

use std::ops::ControlFlow;
use std::path::Path;

use dsm_core::{HitSource, MapInfo, Progress, Transmittance};
use dsm_io::detail::{BakeReport, EncodedTile, KindWriter, Level, Result, TileId};
use dsm_io::{AchievedError, Error, Metadata, WriteOptions};
use dsm_trace::detail::{CutLayers, Layering};
use rayon::prelude::*;

use super::builder::{ListBuilder, ListCounts};
use super::keys::{Filtering, PrefilteredKeys, epsilon_light};
use super::lists::FragmentLists;
use super::pyramid::filtered;
use super::settings::PrefilterSettings;
use super::store::{Prefiltered, encode};

/// Bakes a prefiltered map into a file that replaces `output`, if there is one, in tiles
/// as `options` say. `describe` may add to what the map says of itself, such as its
/// light, which ε may follow; `watch` is told of rows of texels before each, and may
/// break it off. Holds the map.
///
/// # Errors
///
/// [`Error::HitSource`] with what the source says, [`Error::Interrupted`] if `watch`
/// broke it off, else what keeps the file from being written.
pub fn bake_prefiltered<T: Transmittance, S: HitSource<T>>(
    builder: &ListBuilder,
    settings: &PrefilterSettings,
    source: &S,
    output: &Path,
    options: WriteOptions,
    describe: impl FnOnce(&mut Metadata),
    watch: impl FnMut(Progress) -> ControlFlow<()>,
) -> Result<BakeReport>
where
    S::Error: std::error::Error + Send + Sync + 'static,
{
    let collected = builder.collect::<T, S>(source, watch);
    let collected = collected.map_err(|error| Error::HitSource(Box::new(error)))?;
    let (lists, counts) = builder.sort(collected.ok_or(Error::Interrupted)?)?;
    write_prefiltered(builder, settings, (lists, counts), output, options, describe)
}

/// As [`bake_prefiltered`], from lists that are there already.
///
/// # Errors
///
/// What keeps the file from being written.
pub fn write_prefiltered<T: Transmittance>(
    builder: &ListBuilder,
    settings: &PrefilterSettings,
    (lists, counts): (FragmentLists<T>, ListCounts),
    output: &Path,
    options: WriteOptions,
    describe: impl FnOnce(&mut Metadata),
) -> Result<BakeReport> {
    let [width, height] = builder.frame().size();
    let info = MapInfo::new().with_camera(*builder.camera()).with_samples(1);
    let mut metadata = Metadata::new(width, height, T::CHANNELS as u8, info);
    describe(&mut metadata);
    let light = epsilon_light(metadata.info.light);
    let (plan, _) = settings.plan([width, height])?;
    let ListCounts { hits, cut_pixels, most_gained, mean_gained } = counts;
    let gained = [most_gained, mean_gained].map(|gained| gained as f32);
    let left_out = CutLayers { pixels: cut_pixels, max: gained[0], mean: gained[1], sum: None };
    let keys = PrefilteredKeys {
        layering: Layering {
            resets: 0,
            max_layers: builder.layers(),
            // The header keeps an f32; the camera was moved back by one.
            light_depth: builder.frame().light_depth() as f32,
        },
        filtering: Filtering::new(settings, &plan),
        left_out: (cut_pixels > 0).then_some(left_out),
    };
    let texel = builder.frame().footprint(1.0);
    let (levels, geometry) = filtered(lists, settings, texel, light)?;
    let mut writer = KindWriter::<Prefiltered>::create(output, metadata, &keys, options)?;
    for (number, geometry) in (0..).zip(&geometry).skip(1) {
        let [x, y] = geometry.origin;
        let [width, height] = geometry.size;
        writer.add_level(Level {
            number,
            x,
            y,
            ..Level::new(width, height, options.tile_size, 0.0)
        })?;
    }
    for (index, lists) in (0..).zip(&levels) {
        write_level(&mut writer, index, lists)?;
    }
    let bytes = writer.finish()?;
    Ok(BakeReport { hits, cut_pixels, gained, bytes, ..BakeReport::default() })
}

/// Writes the tiles of a level, a row of tiles at a time.
fn write_level<T: Transmittance>(
    writer: &mut KindWriter<Prefiltered>,
    index: u32,
    lists: &FragmentLists<T>,
) -> Result<()> {
    let level = writer.levels()[index as usize];
    let packing = writer.options().packing;
    let [columns, rows] = level.tiles();
    for y in 0..rows {
        let encoded = |x: u32| -> Result<EncodedTile> {
            let Some(rect) = level.tile_rect(x, y) else { return Ok(EncodedTile::default()) };
            encode(&lists.part(rect.x, rect.y, [rect.width, rect.height])?, packing)
        };
        let tiles: Vec<_> = (0..columns).into_par_iter().map(encoded).collect();
        for (x, tile) in (0..columns).zip(tiles) {
            writer.write_encoded(TileId::new(index, x, y), &tile?, AchievedError::NONE)?;
        }
    }
    Ok(())
}
