//! Bakes of maps of fragments into files.

use std::ops::ControlFlow;
use std::path::Path;

use dsm_core::{HitSource, MapInfo, Progress, Tolerance, Transmittance};
use dsm_io::detail::{BakeReport, Crop, KindWriter, Level, MapKind, Result, TileId, TileRect};
use dsm_io::{AchievedError, Codec, Error, Metadata, WriteOptions};
use dsm_trace::detail::{CutSum, Layering};
use rayon::prelude::*;

use super::builder::FragmentBuilder;
use super::keys::{FragmentKeys, MediaKeys};
use super::media::builder::MOST_SLABS;
use super::store::Fragments;

/// Tiles that are built at once, for each thread.
const TILES_A_THREAD: usize = 4;

/// Bakes a map of fragments, or a crop of one, into a file that replaces `output`, if there
/// is one, in tiles as `options` say. `describe` may add to what the map says of itself;
/// `watch` is told of tiles before each few, and may break it off. Holds four tiles a thread.
/// A crop's tiles have the bytes of the whole map's. Tells the bound that the errors of media
/// keep.
///
/// # Errors
///
/// [`Error::HitSource`] with what the source says, [`Error::Interrupted`] if `watch`
/// broke it off, [`Error::Setting`] for a crop that cuts tiles, else what keeps the file from
/// being written.
pub fn bake_fragments<T: Transmittance, S: HitSource<T>>(
    builder: &FragmentBuilder,
    source: &S,
    (output, crop): (&Path, Option<Crop>),
    options: WriteOptions,
    describe: impl FnOnce(&mut Metadata),
    mut watch: impl FnMut(Progress) -> ControlFlow<()>,
) -> Result<(BakeReport, Tolerance)>
where
    S::Error: std::error::Error + Send + Sync + 'static,
{
    let [width, height] = builder.frame().size();
    let coverage = builder.coverage();
    let has_media = source.has_media();
    let asked = if has_media { builder.tolerance() } else { Tolerance::EXACT };
    let mut tolerance = asked;
    let info = MapInfo::new().with_camera(*builder.camera()).with_samples(coverage * coverage);
    let mut metadata =
        Metadata::new(width, height, T::CHANNELS as u8, info.with_tolerance(tolerance));
    describe(&mut metadata);
    let layering = Layering {
        resets: 0,
        max_layers: builder.layers(),
        // The header keeps an f32; the camera was moved back by one.
        light_depth: builder.frame().light_depth() as f32,
    };
    let media = has_media.then_some(MediaKeys { max_slabs: MOST_SLABS as u32 });
    let mut keys = FragmentKeys { layering, coverage, folded: None, media };
    let mut writer = KindWriter::<Fragments>::create_part(output, metadata, crop, &keys, options)?;
    let level = writer.levels()[0];
    let tiles: u64 = level.tile_count();
    let batch = TILES_A_THREAD * rayon::current_num_threads();
    let (mut report, mut cut) = (BakeReport::default(), CutSum::default());
    for first in (0..tiles).step_by(batch) {
        if watch(Progress::new(first, tiles)).is_break() {
            return Err(Error::Interrupted);
        }
        let places: Vec<_> = (first..tiles.min(first + batch as u64))
            .filter_map(|index| place(&level, index))
            .collect();
        let rects: Vec<TileRect> = places.iter().map(|&(_, rect)| rect).collect();
        let built = builder.tiles::<T, S>(source, &rects);
        let built = built.map_err(|error| Error::HitSource(Box::new(error)))?;
        let encode = |tile| Fragments::encode(tile, Codec::Exact, options.packing);
        let encoded: Vec<_> = built.par_iter().map(|built| encode(&built.tile)).collect();
        for ((&(id, _), built), encoded) in places.iter().zip(&built).zip(encoded) {
            report.hits += built.hits;
            cut.add_tile(built.cut_pixels, built.most_gained, built.sum_gained);
            // Beyond what was asked for the largest error counts, whatever comes first.
            let needed = needed(asked, built.error)?;
            if let Some(needed) = needed.filter(|needed| needed.epsilon() > tolerance.epsilon()) {
                tolerance = needed;
                writer.raise_tolerance(needed, &keys)?;
            }
            writer.write_encoded(id, &encoded?, built.error)?;
        }
    }
    if let Some(folded) = cut.of_map(level.pixel_count(), crop.is_some()) {
        report.cut_pixels = folded.pixels;
        report.gained = [folded.max, folded.mean];
        keys.folded = Some(folded);
        writer.set_keys(&keys)?;
    }
    Ok((BakeReport { bytes: writer.finish()?, ..report }, tolerance))
}

/// A tile's place in its level, and its pixels in those of the map.
fn place(level: &Level, index: u64) -> Option<(TileId, TileRect)> {
    let columns = u64::from(level.tiles()[0]);
    // A level has 2³² columns and rows at most.
    let [x, y] = [index % columns, index / columns].map(|place| place as u32);
    let rect = level.tile_rect(x, y)?;
    let [left, top] = [level.x, level.y].map(i32::unsigned_abs);
    Some((TileId::new(0, x, y), TileRect { x: rect.x + left, y: rect.y + top, ..rect }))
}

/// The tolerance that a tile of this error asks for beyond the one that is stated: where
/// pixels would need more slabs than they may have.
fn needed(stated: Tolerance, error: AchievedError) -> Result<Option<Tolerance>> {
    if error.is_within(stated.epsilon()) {
        return Ok(None);
    }
    // A tolerance is less than 1, and errors may be as much.
    Ok(Some(Tolerance::new(error.max.min(1.0_f32.next_down()))?))
}
