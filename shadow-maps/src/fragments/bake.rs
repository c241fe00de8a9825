//! Bakes of maps of fragments into files.

use std::ops::ControlFlow;
use std::path::Path;

use dsm_core::{HitSource, MapInfo, Progress, Tolerance, Transmittance};
use dsm_io::detail::{BakeReport, KindWriter, MapKind, Result, TileId, TileRect};
use dsm_io::{AchievedError, Codec, Error, Metadata, WriteOptions};
use dsm_trace::detail::Layering;
use rayon::prelude::*;

use super::builder::{FragmentBuilder, FragmentCounts};
use super::columns::FragmentColumns;
use super::keys::{Folded, FragmentKeys, MediaKeys};
use super::map::FragmentMap;
use super::media::builder::MOST_SLABS;
use super::media::columns::MediaColumns;
use super::store::Fragments;
use super::tile::FragmentTile;

/// Bakes a map of fragments into a file that replaces `output`, if there is one,
/// in tiles as `options` say. `describe` may add to what the map says of itself;
/// `watch` is told of rows of pixels before each, and may break it off. Holds the map. Tells the
/// bound that the errors of media keep.
///
/// # Errors
///
/// [`Error::HitSource`] with what the source says, [`Error::Interrupted`] if `watch`
/// broke it off, else what keeps the file from being written.
pub fn bake_fragments<T: Transmittance, S: HitSource<T>>(
    builder: &FragmentBuilder,
    source: &S,
    output: &Path,
    options: WriteOptions,
    describe: impl FnOnce(&mut Metadata),
    watch: impl FnMut(Progress) -> ControlFlow<()>,
) -> Result<(BakeReport, Tolerance)>
where
    S::Error: std::error::Error + Send + Sync + 'static,
{
    let built = builder.build_counted::<T, S>(source, watch);
    let built = built.map_err(|error| Error::HitSource(Box::new(error)))?;
    let (map, counts) = built.ok_or(Error::Interrupted)?;
    let [width, height] = map.size();
    let coverage = builder.coverage();
    let errors = MediaErrors { width, of_pixels: &counts.media_errors };
    let tolerance = errors.tolerance(builder.tolerance(), map.media().is_some())?;
    let info = MapInfo::new().with_camera(*builder.camera()).with_samples(coverage * coverage);
    let info = info.with_tolerance(tolerance);
    let mut metadata = Metadata::new(width, height, T::CHANNELS as u8, info);
    describe(&mut metadata);
    let layering = Layering {
        resets: 0,
        max_layers: builder.layers(),
        // The header keeps an f32; the camera was moved back by one.
        light_depth: builder.frame().light_depth() as f32,
    };
    let FragmentCounts { hits, cut_pixels, most_gained, mean_gained, .. } = counts;
    let folded = Folded { pixels: cut_pixels, max: most_gained as f32, mean: mean_gained as f32 };
    let folded = (cut_pixels > 0).then_some(folded);
    let media = map.media().map(|_| MediaKeys { max_slabs: MOST_SLABS as u32 });
    let keys = FragmentKeys { layering, coverage, folded, media };
    let mut writer = KindWriter::<Fragments>::create(output, metadata, &keys, options)?;
    let level = writer.levels()[0];
    let [columns, rows] = level.tiles();
    for y in 0..rows {
        let encode = |x: u32| {
            let rect = level.tile_rect(x, y)?;
            let tile = cut_tile(&map, rect).map_err(Error::from);
            let encode = |tile| Fragments::encode(&tile, Codec::Exact, options.packing);
            Some(tile.and_then(encode).map(|encoded| (encoded, errors.of(rect))))
        };
        let tiles: Vec<_> = (0..columns).into_par_iter().map(encode).collect();
        for (x, encoded) in (0..columns).zip(tiles) {
            if let Some(encoded) = encoded {
                let (encoded, error) = encoded?;
                writer.write_encoded(TileId::new(0, x, y), &encoded, error)?;
            }
        }
    }
    let gained = [most_gained, mean_gained].map(|gained| gained as f32);
    let bytes = writer.finish()?;
    Ok((BakeReport { hits, cut_pixels, gained, bytes, ..BakeReport::default() }, tolerance))
}

/// The pixels of a map in a rectangle.
fn cut_tile<T: Transmittance>(
    map: &FragmentMap<T>,
    rect: TileRect,
) -> dsm_core::detail::Result<FragmentTile<T>> {
    let columns = rect.x..rect.x + rect.width;
    let places = (rect.y..rect.y + rect.height)
        .flat_map(|row| columns.clone().map(move |column| (column, row)));
    let mut lists = FragmentColumns::new();
    places.clone().try_for_each(|(x, y)| lists.push_pixel(map.pixel(x, y)))?;
    let tile = FragmentTile::new([rect.width, rect.height], lists)?;
    let Some(of_map) = map.media() else { return Ok(tile) };
    let mut media = MediaColumns::new();
    let width = map.size()[0] as usize;
    for (x, y) in places {
        media.push_pixel(of_map.pixel(y as usize * width + x as usize))?;
    }
    tile.with_media(media)
}

/// The errors of the media of all pixels, row by row; none of a map without.
#[derive(Clone, Copy)]
struct MediaErrors<'a> {
    width: u32,
    of_pixels: &'a [f32],
}

impl MediaErrors<'_> {
    /// The bound that all of them keep: `asked`, but where pixels would need more slabs than
    /// they may have.
    fn tolerance(self, asked: Tolerance, has_media: bool) -> Result<Tolerance> {
        if !has_media {
            return Ok(Tolerance::EXACT);
        }
        let most = self.of_pixels.iter().copied().fold(0.0, f32::max);
        let kept = AchievedError { max: most, mean: 0.0 }.is_within(asked.epsilon());
        // A tolerance is less than 1, and errors may be as much.
        let needed = Tolerance::new(most.min(1.0_f32.next_down()));
        if kept { Ok(asked) } else { Ok(needed?) }
    }

    /// That of a tile.
    fn of(self, rect: TileRect) -> AchievedError {
        if self.of_pixels.is_empty() {
            return AchievedError::NONE;
        }
        let (mut most, mut sum) = (0.0_f32, 0.0);
        for y in rect.y..rect.y + rect.height {
            let first = y as usize * self.width as usize + rect.x as usize;
            for &error in &self.of_pixels[first..first + rect.width as usize] {
                most = most.max(error);
                sum += f64::from(error);
            }
        }
        let pixels = f64::from(rect.width) * f64::from(rect.height);
        AchievedError::enclosing(most.into(), sum / pixels)
    }
}
