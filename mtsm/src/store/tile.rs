//! The pixels of a tile to columns of words, and back.

use dsm_core::{PixelListsView, Transmittance};
use dsm_io::{Block, ColumnReader, EncodedTile, PixelBlock, Result, TileColumn};

use super::LayeredKind;
use crate::depth_layers::DepthLayers;
use crate::layered_pixels::{LayeredPixels, LayeredPixelsBuilder};
use crate::multilayer_settings::Layering;

/// Pixels as they are stored: the tile of a kind of map.
pub(super) trait StoredTile: PixelBlock + Sized {
    /// The kind of map.
    const KIND: LayeredKind;
    /// Number of channels.
    const CHANNELS: usize;

    fn encode(&self, block: Block) -> Result<EncodedTile>;

    /// A tile without layers.
    fn empty(size: (u32, u32), layering: &Layering) -> Result<Self>;

    fn decode(size: (u32, u32), layering: &Layering, columns: ColumnReader<'_>) -> Result<Self>;
}

/// The smallest and the largest of the depths of pixels or runs, each sorted.
fn range_of(ranges: impl Iterator<Item = [f32; 2]>) -> [f32; 2] {
    let range = ranges.fold([f32::INFINITY, 0.0_f32], |[low, high], [first, last]| {
        [low.min(first), high.max(last)]
    });
    range.map(|z| z + 0.0)
}

fn functions_range<T: Transmittance>(functions: PixelListsView<'_, T>) -> [f32; 2] {
    range_of(functions.functions().filter_map(|function| match function.depths() {
        [first, .., last] | [first @ last] => Some([*first, *last]),
        [] => None,
    }))
}

impl<T: Transmittance> StoredTile for LayeredPixels<T> {
    const KIND: LayeredKind = LayeredKind::Mtsm;
    const CHANNELS: usize = T::CHANNELS;

    fn encode(&self, block: Block) -> Result<EncodedTile> {
        let functions = self.functions().view();
        if self.layer_count() == 0 {
            return Ok(EncodedTile::default());
        }
        let runs = [functions.width()];
        let mut flags = Vec::new();
        let [starts, value_starts, flags, depths, values] =
            TileColumn::of_functions(functions, &mut flags);
        let columns = [
            TileColumn::flags(&runs),
            TileColumn::table(self.run_starts()),
            starts,
            value_starts,
            flags,
            depths,
            values,
            TileColumn::of(self.counts()),
        ];
        let count = self.layer_count() as u64;
        EncodedTile::of_columns(&columns, count, functions_range(functions), block)
    }

    fn empty((width, height): (u32, u32), _: &Layering) -> Result<Self> {
        let mut pixels = LayeredPixelsBuilder::new(width, height);
        for _ in 0..u64::from(width) * u64::from(height) {
            pixels.finish_pixel()?;
        }
        Ok(pixels.finish()?)
    }

    fn decode(
        size: (u32, u32),
        layering: &Layering,
        mut columns: ColumnReader<'_>,
    ) -> Result<Self> {
        let runs = columns.take(1)?[0];
        let layers = columns.entry().vertex_count;
        if layers == 0 || u64::from(runs) > layers {
            return Err(columns.refuse("it has more runs than layers"));
        }
        let run_starts = columns.take(u64::from(size.0) * u64::from(size.1) + 1)?;
        let functions = columns.take_functions::<T>(runs, layers, layers)?;
        let counts = columns.take(layers)?;
        let pixels = Self::new(size, run_starts, functions, counts)
            .map_err(|error| columns.refuse_pixel(error))?;
        for pixel in 0..pixels.pixel_count() {
            if pixels.runs(pixel).len() as u64 > u64::from(layering.resets) + 1 {
                return Err(columns.refuse("a pixel has more runs than the map allows"));
            }
            if pixels.falling_layers(pixel) > layering.max_layers as usize {
                return Err(columns.refuse("a pixel has more layers than the map allows"));
            }
        }
        let range = functions_range(pixels.functions().view());
        columns.finish(range)?;
        Ok(pixels)
    }
}

impl<T: Transmittance> StoredTile for DepthLayers<T> {
    const KIND: LayeredKind = LayeredKind::Layers;
    const CHANNELS: usize = T::CHANNELS;

    fn encode(&self, block: Block) -> Result<EncodedTile> {
        if self.layer_count() == 0 {
            return Ok(EncodedTile::default());
        }
        let opacities: Vec<f32> = (0..T::CHANNELS)
            .flat_map(|channel| self.opacities().iter().map(move |value| value.channel(channel)))
            .collect();
        let columns = [
            TileColumn::table(self.starts()),
            TileColumn::of_floats(self.depths()),
            TileColumn::of_floats(&opacities),
        ];
        let range = range_of((0..self.pixel_count()).filter_map(|pixel| self.depth_range(pixel)));
        EncodedTile::of_columns(&columns, self.layer_count() as u64, range, block)
    }

    fn empty((width, height): (u32, u32), layering: &Layering) -> Result<Self> {
        let starts = vec![0; width as usize * height as usize + 1];
        Ok(Self::new((width, height), layering.max_layers, starts, Vec::new(), Vec::new())?)
    }

    fn decode(
        size: (u32, u32),
        layering: &Layering,
        mut columns: ColumnReader<'_>,
    ) -> Result<Self> {
        let layers = columns.entry().vertex_count;
        let starts = columns.take(u64::from(size.0) * u64::from(size.1) + 1)?;
        let depths = columns.take_floats(layers)?;
        let values = columns.take_floats(layers.saturating_mul(T::CHANNELS as u64))?;
        let count = depths.len();
        let opacity = |layer| T::from_channels(|channel| values[channel * count + layer]);
        let opacities = (0..count).map(opacity).collect();
        let pixels = Self::new(size, layering.max_layers, starts, depths, opacities)
            .map_err(|error| columns.refuse_pixel(error))?;
        if count == 0 {
            return Err(columns.refuse("a tile without layers is empty"));
        }
        let range = (0..pixels.pixel_count()).filter_map(|pixel| pixels.depth_range(pixel));
        columns.finish(range_of(range))?;
        Ok(pixels)
    }
}
