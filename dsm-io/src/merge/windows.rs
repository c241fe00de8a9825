//! Maps of several data windows of one picture into one map.

use std::path::Path;

use dsm_core::detail::PixelWindow;
use dsm_core::{Compression, CompressionMethod, Rgb, Tolerance, Transmittance};
use rayon::prelude::*;

use crate::achieved_error::AchievedError;
use crate::blocks::{
    BLOCKS_A_THREAD, Blocks, is_empty, stated_depth_error, stated_error, tiles_of,
};
use crate::codec::{Codec, Packing};
use crate::error::{Result, check_limit};
use crate::format::encoded_tile::EncodedTile;
use crate::format::level::Level;
use crate::limits::Limits;
use crate::measured_pixels::MeasuredPixels;
use crate::metadata::Metadata;
use crate::progress::{Watch, tell};
use crate::reader::MapReader;
use crate::region::AnyRegion;
use crate::tile_id::{TileId, TileRect};
use crate::write_options::WriteOptions;
use crate::writer::MapWriter;

/// Maps of disjoint data windows of one picture, as a render in stripes or tiles
/// leaves them.
pub(super) struct Windows<'a> {
    maps: &'a [MapReader],
    /// First column and row of each in the whole.
    corners: Vec<[u32; 2]>,
    metadata: Metadata,
}

/// A tile of the whole, and how well it is known.
struct JoinedTile {
    id: TileId,
    encoded: EncodedTile,
    achieved: AchievedError,
}

impl<'a> Windows<'a> {
    /// The maps as parts of one, if they are: of one display window and camera, in
    /// data windows that share no pixel.
    pub(super) fn of(maps: &'a [MapReader]) -> Option<Self> {
        let first = maps.first()?.metadata().info;
        let is_part = |map: &MapReader| {
            let info = map.metadata().info;
            map.crop().is_none()
                && info.camera == first.camera
                && info.display_window == first.display_window
                && info.depth_kind == first.depth_kind
                && info.light == first.light
        };
        first.display_window?;
        let windows =
            maps.iter().map(|map| map.metadata().info.data_window.filter(|_| is_part(map)));
        let windows: Vec<PixelWindow> = windows.collect::<Option<_>>()?;
        let apart = |a: &PixelWindow, b: &PixelWindow| {
            (0..2).any(|axis| a.max[axis] < b.min[axis] || b.max[axis] < a.min[axis])
        };
        let are_apart =
            |(index, window): (usize, _)| windows[..index].iter().all(|other| apart(window, other));
        if !windows.iter().enumerate().all(are_apart) {
            return None;
        }
        let whole = windows.iter().skip(1).fold(windows[0], |whole, window| PixelWindow {
            min: [0, 1].map(|axis| whole.min[axis].min(window.min[axis])),
            max: [0, 1].map(|axis| whole.max[axis].max(window.max[axis])),
        });
        let length = |axis: usize| {
            u32::try_from(i64::from(whole.max[axis]) - i64::from(whole.min[axis]) + 1).ok()
        };
        let corners = windows
            .iter()
            .map(|window| [0, 1].map(|axis| window.min[axis].abs_diff(whole.min[axis])));
        let corners = corners.collect();
        let all = || maps.iter().map(MapReader::metadata);
        let mut info = first;
        info.data_window = Some(whole);
        let tolerances = all().map(|metadata| metadata.info.tolerance);
        info.tolerance = tolerances
            .reduce(|a, b| if a.epsilon() < b.epsilon() { b } else { a })
            .unwrap_or_default();
        info.compression =
            info.compression.filter(|_| all().all(|own| own.info.compression == info.compression));
        info.samples = info.samples.filter(|_| all().all(|own| own.info.samples == info.samples));
        info.filter = info.filter.filter(|_| all().all(|own| own.info.filter == info.filter));
        let channels = all().map(|metadata| metadata.channels).max().unwrap_or(1);
        let mut metadata = Metadata::new(length(0)?, length(1)?, channels, info);
        metadata.attributes.clone_from(&maps.first()?.metadata().attributes);
        Some(Self { maps, corners, metadata })
    }

    /// Writes the whole, in tiles of the first map's size.
    pub(super) fn join(&self, output: &Path, progress: Watch<'_>) -> Result<()> {
        let pixels = u64::from(self.metadata.width) * u64::from(self.metadata.height);
        check_limit("pixels", pixels, Limits::default().max_pixels)?;
        let blocks = self.maps.iter().map(MapReader::packing).collect::<Result<Vec<_>>>()?;
        let block = blocks.into_iter().flatten().next().unwrap_or(Packing::Zstd);
        let tile_size = self.maps.iter().map(|map| map.levels()[0].tile_width).next().unwrap_or(64);
        let options = WriteOptions::default().with_tile_size(tile_size).with_packing(block);
        let mut writer = MapWriter::create(output, self.metadata.clone(), options)?;
        let level = writer.levels()[0];
        let blocks = Blocks::new(&level, self.maps.iter().map(|map| &map.levels()[0]));
        let batch = BLOCKS_A_THREAD * rayon::current_num_threads() as u64;
        for start in (0..blocks.count()).step_by(batch as usize) {
            let end = start.saturating_add(batch).min(blocks.count());
            let tiles = (start..end)
                .into_par_iter()
                .map(|index| match self.metadata.channels {
                    1 => self.block::<f32>(&level, blocks.rect(index), block),
                    _ => self.block::<Rgb>(&level, blocks.rect(index), block),
                })
                .collect::<Result<Vec<_>>>()?;
            for JoinedTile { id, encoded, achieved } in tiles.into_iter().flatten() {
                writer.write_encoded(id, &encoded, achieved)?;
            }
            tell(progress, end, blocks.count())?;
        }
        writer.finish()?;
        Ok(())
    }

    /// What a map holds of a rectangle of the whole, in pixels of the map.
    fn shared(&self, index: usize, rect: TileRect) -> Option<TileRect> {
        let (metadata, corner) = (self.maps[index].metadata(), self.corners[index]);
        let axis = |first: u32, length: u32, corner: u32, size: u32| {
            let start = first.max(corner);
            let end = (first + length).min(corner + size);
            (start < end).then(|| (start - corner, end - start))
        };
        let (x, width) = axis(rect.x, rect.width, corner[0], metadata.width)?;
        let (y, height) = axis(rect.y, rect.height, corner[1], metadata.height)?;
        Some(TileRect { x, y, width, height })
    }

    /// The tiles of a block of the whole.
    fn block<T: Transmittance>(
        &self,
        level: &Level,
        block: TileRect,
        packing: Packing,
    ) -> Result<Vec<JoinedTile>> {
        let mut regions = Vec::new();
        for (index, map) in self.maps.iter().enumerate() {
            let Some(own) = self.shared(index, block) else { continue };
            // What is clear everywhere needs no functions.
            if !is_empty(map, 0, own)? {
                regions.push((index, AnyRegion::<T>::read(map, 0, own)?));
            }
        }
        tiles_of(0, level, block)
            .filter_map(|id| Some((id, level.tile_rect(id.x, id.y)?)))
            .map(|(id, rect)| self.tile(&regions, id, rect, packing))
            .collect()
    }

    fn tile<T: Transmittance>(
        &self,
        regions: &[(usize, AnyRegion<'_, T>)],
        id: TileId,
        rect: TileRect,
        packing: Packing,
    ) -> Result<JoinedTile> {
        let mut parts = Vec::new();
        let (mut covered, mut depth_error) = (0, 0.0_f32);
        let mut found = Vec::new();
        for (index, region) in regions {
            let Some(own) = self.shared(*index, rect) else { continue };
            let map = &self.maps[*index];
            covered += own.pixel_count();
            parts.push((stated_error(map, 0, own)?, own.pixel_count()));
            depth_error = depth_error.max(stated_depth_error(map, 0, own)?);
            found.push((self.corners[*index], own, region));
        }
        parts.push((AchievedError::NONE, rect.pixel_count() - covered));
        let achieved = AchievedError::of_parts(parts);
        if found.is_empty() {
            return Ok(JoinedTile { id, encoded: EncodedTile::default(), achieved });
        }
        // Functions are copied: nothing is added to their errors.
        let size = [rect.width, rect.height];
        let copied = Compression::new(CompressionMethod::Greedy);
        let mut pixels = MeasuredPixels::<T>::new(size, Tolerance::EXACT, copied);
        let mut function = Vec::new();
        for (y, x) in (0..rect.height).flat_map(|y| (0..rect.width).map(move |x| (y, x))) {
            let owner = found.iter().find_map(|(corner, own, region)| {
                let x = (rect.x + x).checked_sub(corner[0])?;
                let y = (rect.y + y).checked_sub(corner[1])?;
                let is_own = (own.x..own.x + own.width).contains(&x)
                    && (own.y..own.y + own.height).contains(&y);
                is_own.then_some((region, x, y))
            });
            match owner {
                Some((region, x, y)) => {
                    region.copy_function(x, y, &mut function);
                    pixels.push(&function, 0.0)?;
                }
                None => pixels.push_clear()?,
            }
        }
        let (pixels, _) = pixels.finish()?;
        let encoded = EncodedTile::encode(pixels.view(), Codec::Exact, packing)?;
        Ok(JoinedTile { id, encoded: encoded.with_depth_error(depth_error), achieved })
    }
}
