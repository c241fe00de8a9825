//! Maps of the same pixels into the light past all of them.

use std::path::Path;

use dsm_core::detail::VisibilityProduct;
use dsm_core::{Compression, Rgb, Tolerance, Transmittance};
use rayon::prelude::*;

use super::{MergeReport, refuse};
use crate::achieved_error::AchievedError;
use crate::blocks::{
    BLOCKS_A_THREAD, Blocks, is_empty, stated_depth_error, stated_error, tiles_of,
};
use crate::codec::{Codec, Packing};
use crate::error::{Error, Result};
use crate::format::encoded_tile::EncodedTile;
use crate::format::level::Level;
use crate::format::write::ContainerWriter;
use crate::measured_pixels::MeasuredPixels;
use crate::metadata::Metadata;
use crate::progress::{Watch, tell};
use crate::reader::MapReader;
use crate::region::AnyRegion;
use crate::tile_id::{TileId, TileRect};

/// Multiplies level 0 of maps of the same pixels.
pub(super) fn multiply(
    maps: &[MapReader],
    output: &Path,
    added: Tolerance,
    progress: Watch<'_>,
) -> Result<MergeReport> {
    let Some(first) = maps.first() else { return Err(Error::setting("there is nothing to merge")) };
    let metadata = metadata(first, maps, added)?;
    let json = metadata.to_json()?;
    let tolerance = metadata.info.tolerance;
    let level =
        Level { tolerance: tolerance.epsilon(), error: AchievedError::NONE, ..first.levels()[0] };
    // As the first map that says anything of it.
    let packings = maps.iter().map(MapReader::packing).collect::<Result<Vec<_>>>()?;
    let packing = packings.into_iter().flatten().next().unwrap_or(Packing::Zstd);
    let compression = Compression::of_stated(metadata.info.compression);
    let product = Product { maps, level, added, compression, packing };
    let blocks = Blocks::new(&level, maps.iter().map(|map| &map.levels()[0]));
    let mut writer = ContainerWriter::create(output)?;
    writer.add_level(level)?;
    let batch = BLOCKS_A_THREAD * rayon::current_num_threads() as u64;
    for start in (0..blocks.count()).step_by(batch as usize) {
        let end = start.saturating_add(batch).min(blocks.count());
        let tiles = (start..end)
            .into_par_iter()
            .map(|index| match metadata.channels {
                1 => product.block::<f32>(blocks.rect(index)),
                _ => product.block::<Rgb>(blocks.rect(index)),
            })
            .collect::<Result<Vec<_>>>()?;
        for MultipliedTile { id, encoded, achieved } in tiles.into_iter().flatten() {
            writer.write_tile(id, &encoded, achieved)?;
        }
        tell(progress, end, blocks.count())?;
    }
    writer.finish(&json)?;
    let lost_levels = maps.iter().map(|map| map.levels().len() - 1).sum();
    Ok(MergeReport::Multiplied { tolerance, lost_levels })
}

/// What the product says of itself, or of the whole map it is a crop of.
fn metadata(first: &MapReader, maps: &[MapReader], added: Tolerance) -> Result<Metadata> {
    let stated = first.whole_metadata();
    let mut info = stated.info;
    for map in maps {
        let other = map.whole_metadata().info;
        if other.depth_kind != info.depth_kind {
            return Err(refuse(map, "its depths are of another kind than the first map's".into()));
        }
        // What a map doesn't know doesn't contradict.
        let differs = agree(&mut info.camera, other.camera, "camera")
            .or_else(|| agree(&mut info.data_window, other.data_window, "data window"))
            .or_else(|| agree(&mut info.display_window, other.display_window, "display window"));
        if let Some(what) = differs {
            return Err(refuse(map, format!("its {what} differs from an earlier map's")));
        }
        info.samples = info.samples.filter(|_| other.samples == info.samples);
        // The product is on the side that all factors keep to.
        info.compression = info.compression.filter(|_| other.compression == info.compression);
        info.filter = info.filter.filter(|_| other.filter == info.filter);
    }
    info.tolerance = tolerance(maps, added)?;
    let channels = maps.iter().map(|map| map.metadata().channels).max().unwrap_or(1);
    let mut metadata = Metadata::new(stated.width, stated.height, channels, info);
    metadata.attributes = stated.attributes.clone();
    Ok(metadata)
}

/// Learns what another map knows; says `what` if the two know differently.
fn agree<V: Copy + PartialEq>(
    known: &mut Option<V>,
    other: Option<V>,
    what: &'static str,
) -> Option<&'static str> {
    match (*known, other) {
        (Some(known), Some(other)) => (known != other).then_some(what),
        (None, _) => {
            *known = other;
            None
        }
        (_, None) => None,
    }
}

/// The bound of the product: |ab − a′b′| ≤ |a − a′| + |b − b′|.
fn tolerance(maps: &[MapReader], added: Tolerance) -> Result<Tolerance> {
    let levels = || maps.iter().map(|map| map.levels()[0]);
    let epsilon = f64::from(added.epsilon());
    let stated = levels().map(|level| level.tolerance).sum::<f32>() + added.epsilon();
    // Each map may be off by the slack more than it states, the product only
    // once; its own chords and rounding come on top.
    let own = epsilon.max(Tolerance::CHORD_FLOOR) + f64::from(f32::EPSILON);
    let needed = levels().map(|level| f64::from(level.error.max)).sum::<f64>() + own;
    let stated = stated.max((needed - f64::from(AchievedError::SLACK)) as f32);
    Tolerance::new(stated).map_err(|_| {
        Error::setting(format!(
            "the tolerances of the maps and what the product may add come to {stated}: no bound"
        ))
    })
}

struct Product<'a> {
    maps: &'a [MapReader],
    level: Level,
    added: Tolerance,
    compression: Compression,
    packing: Packing,
}

struct MultipliedTile {
    id: TileId,
    encoded: EncodedTile,
    achieved: AchievedError,
}

impl Product<'_> {
    /// Multiplies the tiles of a block.
    fn block<T: Transmittance>(&self, block: TileRect) -> Result<Vec<MultipliedTile>> {
        let mut regions = Vec::new();
        for map in self.maps {
            // What is clear everywhere is no factor.
            if !is_empty(map, 0, block)? {
                regions.push(AnyRegion::<T>::read(map, 0, block)?);
            }
        }
        tiles_of(0, &self.level, block)
            .collect::<Vec<_>>()
            .into_par_iter()
            .map(|id| {
                let rect = self.level.tile_rect(id.x, id.y).ok_or(Error::NoSuchTile(id))?;
                let (mut encoded, own) = self.tile(&regions, rect)?;
                let mut achieved = own;
                for map in self.maps {
                    encoded = encoded.with_depth_error(stated_depth_error(map, 0, rect)?);
                    let stated = stated_error(map, 0, rect)?;
                    achieved.max += stated.max;
                    achieved.mean += stated.mean;
                }
                let max = achieved.max.min(1.0);
                let achieved = AchievedError { max, mean: achieved.mean.min(max) };
                Ok(MultipliedTile { id, encoded, achieved })
            })
            .collect()
    }

    /// Multiplies one tile, and measures what that added to the errors.
    fn tile<T: Transmittance>(
        &self,
        regions: &[AnyRegion<'_, T>],
        rect: TileRect,
    ) -> Result<(EncodedTile, AchievedError)> {
        if regions.is_empty() {
            return Ok((EncodedTile::default(), AchievedError::NONE));
        }
        let size = [rect.width, rect.height];
        let mut pixels = MeasuredPixels::<T>::new(size, self.added, self.compression);
        let mut product = VisibilityProduct::<T>::default();
        let mut functions = vec![Vec::new(); regions.len()];
        for (y, x) in (0..rect.height).flat_map(|y| (0..rect.width).map(move |x| (y, x))) {
            for (region, function) in regions.iter().zip(&mut functions) {
                region.copy_function(rect.x + x, rect.y + y, function);
            }
            product.multiply(&functions, self.added.chord());
            pixels.push(product.vertices(), product.chord_error())?;
        }
        let (pixels, achieved) = pixels.finish()?;
        Ok((EncodedTile::encode(pixels.view(), Codec::Exact, self.packing)?, achieved))
    }
}
