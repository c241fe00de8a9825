//! Kind `layers`: multilayer depth maps in files.

use dsm_core::Transmittance;
use dsm_io::detail::{
    EncodedTile, FieldKind, KindReader, MapKind, MapTile, MapTiles, PixelValue, Result, StoredTile,
    TileColumn,
};
use dsm_io::{Codec, Error, MapSummary, Metadata, Packing, PixelContents};

use super::keys::{LayeredKeys, refuse};
use super::tile::{bytes, range_of, summary};
use crate::depth_layers::{DepthLayers, MultilayerDepthMap};
use crate::multilayer_settings::LayeredInfo;

/// The kind `layers`: the first hits of every pixel's ray, a
/// [`MultilayerDepthMap`].
///
/// ```no_run
/// use dsm_io::detail::KindReader;
/// use dsm_io::Limits;
/// use mtsm::detail::{Layers, MultilayerDepthMap};
///
/// let reader = KindReader::<Layers>::open("leaves.dsm", &Limits::default())?;
/// let map = MultilayerDepthMap::<f32>::read(&reader)?;
/// println!("{} layers", map.pixels().layer_count());
/// # Ok::<(), dsm_io::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Layers;

impl<T: Transmittance> MapTile for DepthLayers<T> {
    fn size(&self) -> [u32; 2] {
        [self.width(), self.height()]
    }

    fn bytes(&self) -> u64 {
        bytes(self.starts()) + bytes(self.depths()) + bytes(self.opacities())
    }
}

impl MapKind for Layers {
    const NAME: &'static str = "layers";
    const TITLE: &'static str = "a multilayer depth map";

    const CROPS: bool = true;

    type Keys = LayeredKeys;
    type Tile<T: Transmittance> = DepthLayers<T>;

    fn has_errors(_: &LayeredKeys) -> bool {
        false
    }

    fn check(metadata: &Metadata, keys: &LayeredKeys) -> Result<()> {
        keys.check(Self::NAME)?;
        refuse(keys.layering.broken_rule_of_exact(metadata.info.tolerance))
    }

    fn join_keys(
        crops: &[&LayeredKeys],
        pixels: u64,
    ) -> std::result::Result<LayeredKeys, &'static str> {
        LayeredKeys::join(crops, pixels)
    }

    fn encode<T: Transmittance>(
        tile: &DepthLayers<T>,
        codec: Codec,
        packing: Packing,
    ) -> Result<EncodedTile> {
        if codec != Codec::Exact {
            return Err(Error::Setting("layers are stored exactly".into()));
        }
        if tile.layer_count() == 0 {
            return Ok(EncodedTile::default());
        }
        let opacities: Vec<f32> = (0..T::CHANNELS)
            .flat_map(|channel| tile.opacities().iter().map(move |value| value.channel(channel)))
            .collect();
        let columns = [
            TileColumn::table(tile.starts()),
            TileColumn::of_floats(tile.depths()),
            TileColumn::of_floats(&opacities),
        ];
        let range = range_of((0..tile.pixel_count()).filter_map(|pixel| tile.depth_range(pixel)));
        EncodedTile::of_columns(&columns, tile.layer_count() as u64, range, packing)
    }

    fn empty<T: Transmittance>(
        [width, height]: [u32; 2],
        keys: &LayeredKeys,
    ) -> Result<DepthLayers<T>> {
        let starts = vec![0; width as usize * height as usize + 1];
        let most = keys.layering.max_layers;
        Ok(DepthLayers::new((width, height), most, starts, Vec::new(), Vec::new())?)
    }

    fn decode<T: Transmittance>(
        stored: StoredTile<'_>,
        keys: &LayeredKeys,
    ) -> Result<DepthLayers<T>> {
        let ([width, height], pixels) = (stored.size(), stored.pixel_count());
        let mut columns = stored.columns()?;
        let layers = columns.entry().vertex_count;
        let starts = columns.take(pixels + 1)?;
        let depths = columns.take_floats(layers)?;
        let values = columns.take_floats(layers.saturating_mul(T::CHANNELS as u64))?;
        let count = depths.len();
        let opacity = |layer| T::from_channels(|channel| values[channel * count + layer]);
        let opacities = (0..count).map(opacity).collect();
        let most = keys.layering.max_layers;
        let pixels = DepthLayers::new((width, height), most, starts, depths, opacities)
            .map_err(|error| columns.refuse_pixel(error))?;
        if count == 0 {
            return Err(columns.refuse("a tile without layers is empty"));
        }
        let range = (0..pixels.pixel_count()).filter_map(|pixel| pixels.depth_range(pixel));
        columns.finish(range_of(range))?;
        Ok(pixels)
    }

    fn summarize<T: Transmittance>(tile: &DepthLayers<T>, summary: &mut MapSummary) {
        let lengths = (0..tile.pixel_count()).map(|pixel| tile.layers(pixel).len() as u64);
        let empty = summary.add_lists("layers", "max_layers_per_pixel", lengths);
        summary.add("empty_pixels", empty);
    }

    fn summary<T: Transmittance>(map: &impl MapTiles<Tile = DepthLayers<T>>) -> Result<MapSummary> {
        summary::<Self, T>(map)
    }

    fn contents<T: Transmittance>(tile: &DepthLayers<T>, pixel: usize) -> PixelContents {
        let mut contents = PixelContents::new("layers", &["depth", "opacity"]);
        for layer in tile.layers(pixel) {
            contents.push([PixelValue::Number(layer.depth), PixelValue::light(layer.opacity)]);
        }
        contents
    }
}

/// The product of what the layers up to a depth let through.
impl FieldKind for Layers {
    type View<'t, T: Transmittance> = &'t DepthLayers<T>;

    fn view<T: Transmittance>(tile: &DepthLayers<T>) -> &DepthLayers<T> {
        tile
    }

    fn evaluate<T: Transmittance>(view: &DepthLayers<T>, pixel: usize, depth: f32) -> T {
        view.transmittance(pixel, depth)
    }
}

impl<T: Transmittance> MultilayerDepthMap<T> {
    /// Reads a whole map into memory, its finest level. O(layers).
    ///
    /// # Errors
    ///
    /// As [`MultilayerMap::read`](crate::MultilayerMap::read).
    pub fn read(reader: &KindReader<Layers>) -> Result<Self> {
        reader.check_in_memory(0)?;
        let (metadata, layering) = (reader.metadata(), reader.keys().layering);
        let mut pixels = DepthLayers::clear(metadata.width, metadata.height, layering.max_layers);
        reader.for_each_pixel::<T>(0, |tile, pixel| Ok(pixels.copy_pixel(tile, pixel)?))?;
        Ok(Self::new(LayeredInfo { map: metadata.info, layering }, pixels))
    }
}
