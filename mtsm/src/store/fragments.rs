//! Maps of fragments in files: kind `fragments`.

use std::path::Path;

use dsm_core::{HitSource, MapInfo, Transmittance};
use dsm_io::{
    AchievedError, Block, ColumnReader, EncodedTile, Error, Metadata, PixelBlock, Result,
    TileColumn, TileId,
};
use rayon::prelude::*;
use shadow_maps::fragments::{Fragment, FragmentBuilder, FragmentColumns, FragmentCounts};

use super::bake::{LayeredReport, LayeredWriter};
use super::tile::StoredTile;
use super::{LayeredKeys, LayeredKind};
use crate::multilayer_settings::Layering;

/// The fragments of a tile.
#[derive(Clone, Debug)]
pub(super) struct FragmentTile<T> {
    size: [u32; 2],
    pub(super) columns: FragmentColumns<T>,
}

impl<T: Transmittance> FragmentTile<T> {
    fn clear(size: [u32; 2]) -> Self {
        let columns = FragmentColumns::new();
        Self { size, columns }
    }

    pub(super) fn fragments(&self, pixel: usize) -> impl DoubleEndedIterator<Item = Fragment<T>> {
        let columns = &self.columns;
        let range = columns.offsets[pixel] as usize..columns.offsets[pixel + 1] as usize;
        range.map(|index| columns.fragment(index))
    }

    /// Least and greatest depth of all that is covered.
    fn range(&self) -> [f32; 2] {
        let fragments = (0..self.columns.w.len()).map(|index| self.columns.fragment(index));
        let depths = fragments.map(|fragment| {
            let [low, high] = fragment.range();
            let depth = |w: f32| if w > 0.0 { w.recip().min(f32::MAX) } else { f32::MAX };
            [depth(high), depth(low)]
        });
        let range = depths.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
        range.unwrap_or([0.0; 2])
    }
}

impl<T: Transmittance> PixelBlock for FragmentTile<T> {
    fn size(&self) -> [u32; 2] {
        self.size
    }
}

impl<T: Transmittance> StoredTile for FragmentTile<T> {
    const KIND: LayeredKind = LayeredKind::Fragments;
    const CHANNELS: usize = T::CHANNELS;

    fn encode(&self, block: Block) -> Result<EncodedTile> {
        let FragmentColumns { offsets, w, gradients, facing, opacities, coverage } = &self.columns;
        if w.is_empty() {
            return Ok(EncodedTile::default());
        }
        let opacities: Vec<f32> = (0..T::CHANNELS)
            .flat_map(|channel| opacities.iter().map(move |value| value.channel(channel)))
            .collect();
        let low: Vec<u32> = coverage.iter().map(|&mask| mask as u32).collect();
        let high: Vec<u32> = coverage.iter().map(|&mask| (mask >> 32) as u32).collect();
        let columns = [
            TileColumn::table(offsets),
            TileColumn::of_floats(w),
            TileColumn::of_floats(&gradients[0]),
            TileColumn::of_floats(&gradients[1]),
            TileColumn::flags(facing),
            TileColumn::of_floats(&opacities),
            TileColumn::of(&low),
            TileColumn::of(&high),
        ];
        EncodedTile::of_columns(&columns, w.len() as u64, self.range(), block)
    }

    fn empty((width, height): (u32, u32), _: &Layering) -> Result<Self> {
        let mut tile = Self::clear([width, height]);
        tile.columns.offsets = vec![0; width as usize * height as usize + 1];
        Ok(tile)
    }

    fn decode(
        (width, height): (u32, u32),
        layering: &Layering,
        mut columns: ColumnReader<'_>,
    ) -> Result<Self> {
        let count = columns.entry().vertex_count;
        if count == 0 {
            return Err(columns.refuse("a tile without layers is empty"));
        }
        let offsets = columns.take(u64::from(width) * u64::from(height) + 1)?;
        let w = columns.take_floats(count)?;
        let gradients = [columns.take_floats(count)?, columns.take_floats(count)?];
        let facing = columns.take(count.div_ceil(32))?;
        let values = columns.take_floats(count.saturating_mul(T::CHANNELS as u64))?;
        let [low, high] = [columns.take(count)?, columns.take(count)?];
        let opacity = |at| T::from_channels(|channel| values[channel * w.len() + at]);
        let opacities = (0..w.len()).map(opacity).collect();
        let masks = low.iter().zip(&high);
        let coverage = masks.map(|(&low, &high)| u64::from(high) << 32 | u64::from(low)).collect();
        let read = FragmentColumns { offsets, w, gradients, facing, opacities, coverage };
        read.check([width, height]).map_err(|error| columns.refuse_pixel(error))?;
        let most = read.offsets.windows(2).map(|pair| pair[1] - pair[0]).max().unwrap_or(0);
        if most > layering.max_layers {
            return Err(columns.refuse("a pixel has more layers than the map allows"));
        }
        let tile = Self { size: [width, height], columns: read };
        let range = tile.range();
        columns.finish(range)?;
        Ok(tile)
    }
}

/// Bakes a map of fragments into a file that replaces `output`, if there is one,
/// in tiles of `tile_size` pixels packed as `block`. `info` tells all that the
/// builder does not know, `describe` may add to it. Holds the map.
///
/// # Errors
///
/// [`Error::HitSource`] with what the source says, else what keeps the file from
/// being written.
pub fn bake_fragments<T: Transmittance, S: HitSource<T>>(
    builder: &FragmentBuilder,
    source: &S,
    output: &Path,
    (tile_size, block): (u32, Block),
    describe: impl FnOnce(&mut Metadata),
) -> Result<LayeredReport>
where
    S::Error: std::error::Error + Send + Sync + 'static,
{
    let built = builder.build_counted::<T, S>(source);
    let (map, counts) = built.map_err(|error| Error::HitSource(Box::new(error)))?;
    let [width, height] = map.size();
    let coverage = builder.coverage();
    let info = MapInfo {
        camera: Some(*builder.camera()),
        samples: Some(coverage * coverage),
        ..MapInfo::default()
    };
    let mut metadata = Metadata::new(width, height, T::CHANNELS as u8, info);
    describe(&mut metadata);
    let layering = Layering {
        resets: 0,
        max_layers: builder.layers(),
        // The header keeps an f32; the camera was moved back by one.
        light_depth: builder.frame().light_depth() as f32,
    };
    let keys = LayeredKeys { layering, coverage: Some(coverage) };
    let mut writer =
        LayeredWriter::create(output, LayeredKind::Fragments, &metadata, keys, tile_size)?;
    let level = writer.container.levels()[0];
    let [columns, rows] = level.tiles();
    for y in 0..rows {
        let encode = |x: u32| {
            let rect = level.tile_rect(x, y)?;
            let mut tile = FragmentTile::clear([rect.width, rect.height]);
            let columns = rect.x..rect.x + rect.width;
            let mut places = (rect.y..rect.y + rect.height)
                .flat_map(|row| columns.clone().map(move |column| (column, row)));
            let pushed = places.try_for_each(|(x, y)| tile.columns.push_pixel(map.pixel(x, y)));
            Some(pushed.map_err(Error::from).and_then(|()| tile.encode(block)))
        };
        let tiles: Vec<_> = (0..columns).into_par_iter().map(encode).collect();
        for (x, encoded) in (0..columns).zip(tiles) {
            if let Some(encoded) = encoded {
                let id = TileId::new(0, x, y);
                writer.container.write_tile(id, &encoded?, AchievedError::NONE)?;
            }
        }
    }
    let FragmentCounts { hits, cut_pixels } = counts;
    Ok(LayeredReport { hits, cut_pixels, bytes: writer.finish()? })
}
