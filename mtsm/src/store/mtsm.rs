//! Kind `mtsm`: multilayer transparent shadow maps in files.

use dsm_core::Transmittance;
use dsm_core::detail::{PixelListsView, VisibilityView};
use dsm_io::detail::{
    EncodedTile, FieldKind, KindReader, MapKind, MapTile, MapTiles, PixelValue, Result, StoredTile,
    TileColumn,
};
use dsm_io::{Codec, Error, MapSummary, Metadata, Packing, PixelContents};

use super::keys::LayeredKeys;
use super::tile::{bytes, range_of, summary};
use crate::layered_pixels::{LayeredPixels, LayeredPixelsBuilder};
use crate::multilayer_map::MultilayerMap;
use crate::multilayer_settings::LayeredInfo;

/// The kind `mtsm`: runs of layers with counts, a [`MultilayerMap`].
///
/// ```no_run
/// use dsm_io::detail::KindReader;
/// use dsm_io::Limits;
/// use mtsm::detail::Mtsm;
/// use mtsm::MultilayerMap;
///
/// let reader = KindReader::<Mtsm>::open("fur.dsm", &Limits::default())?;
/// let map = MultilayerMap::<f32>::read(&reader)?;
/// println!("{} layers", map.pixels().layer_count());
/// # Ok::<(), dsm_io::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Mtsm;

fn functions_range<T: Transmittance>(functions: PixelListsView<'_, T>) -> [f32; 2] {
    range_of(functions.functions().filter_map(|function| match function.depths() {
        [first, .., last] | [first @ last] => Some([*first, *last]),
        [] => None,
    }))
}

impl<T: Transmittance> MapTile for LayeredPixels<T> {
    fn size(&self) -> [u32; 2] {
        [self.width(), self.height()]
    }

    fn bytes(&self) -> u64 {
        self.functions().bytes() + bytes(self.run_starts()) + bytes(self.counts())
    }
}

impl MapKind for Mtsm {
    const NAME: &'static str = "mtsm";
    const TITLE: &'static str = "a multilayer transparent shadow map";
    const FUNCTIONS: bool = true;

    const CROPS: bool = true;

    type Keys = LayeredKeys;
    type Tile<T: Transmittance> = LayeredPixels<T>;

    fn check(_: &Metadata, keys: &LayeredKeys) -> Result<()> {
        keys.check(Self::NAME)
    }

    fn join_keys(
        crops: &[&LayeredKeys],
        pixels: u64,
    ) -> std::result::Result<LayeredKeys, &'static str> {
        LayeredKeys::join(crops, pixels)
    }

    fn encode<T: Transmittance>(
        tile: &LayeredPixels<T>,
        codec: Codec,
        packing: Packing,
    ) -> Result<EncodedTile> {
        if codec != Codec::Exact {
            return Err(Error::Setting("layers are stored exactly".into()));
        }
        let functions = tile.functions().view();
        if tile.layer_count() == 0 {
            return Ok(EncodedTile::default());
        }
        let runs = [functions.width()];
        let mut flags = Vec::new();
        let [starts, value_starts, flags, depths, values] =
            TileColumn::of_functions(functions, &mut flags);
        let columns = [
            TileColumn::flags(&runs),
            TileColumn::table(tile.run_starts()),
            starts,
            value_starts,
            flags,
            depths,
            values,
            TileColumn::of(tile.counts()),
        ];
        let count = tile.layer_count() as u64;
        EncodedTile::of_columns(&columns, count, functions_range(functions), packing)
    }

    fn empty<T: Transmittance>(
        [width, height]: [u32; 2],
        _: &LayeredKeys,
    ) -> Result<LayeredPixels<T>> {
        let mut pixels = LayeredPixelsBuilder::new(width, height);
        for _ in 0..u64::from(width) * u64::from(height) {
            pixels.finish_pixel()?;
        }
        Ok(pixels.finish()?)
    }

    fn decode<T: Transmittance>(
        stored: StoredTile<'_>,
        keys: &LayeredKeys,
    ) -> Result<LayeredPixels<T>> {
        let ([width, height], count) = (stored.size(), stored.pixel_count());
        let mut columns = stored.columns()?;
        let runs = columns.take(1)?[0];
        let layers = columns.entry().vertex_count;
        if layers == 0 || u64::from(runs) > layers {
            return Err(columns.refuse("it has more runs than layers"));
        }
        let run_starts = columns.take(count + 1)?;
        let functions = columns.take_functions::<T>(runs, layers, layers)?;
        let counts = columns.take(layers)?;
        let pixels = LayeredPixels::new((width, height), run_starts, functions, counts)
            .map_err(|error| columns.refuse_pixel(error))?;
        for pixel in 0..pixels.pixel_count() {
            if pixels.runs(pixel).len() as u64 > u64::from(keys.layering.resets) + 1 {
                return Err(columns.refuse("a pixel has more runs than the map allows"));
            }
            if pixels.falling_layers(pixel) > keys.layering.max_layers as usize {
                return Err(columns.refuse("a pixel has more layers than the map allows"));
            }
        }
        let range = functions_range(pixels.functions().view());
        columns.finish(range)?;
        Ok(pixels)
    }

    fn summarize<T: Transmittance>(tile: &LayeredPixels<T>, summary: &mut MapSummary) {
        let pixels = || 0..tile.pixel_count();
        let runs = pixels().map(|pixel| tile.runs(pixel).len() as u64);
        summary.add_lists("runs", "max_runs_per_pixel", runs);
        let layers =
            pixels().map(|pixel| tile.runs(pixel).map(|run| run.len() as u64).sum::<u64>());
        let empty = summary.add_lists("layers", "max_layers_per_pixel", layers);
        summary.add("empty_pixels", empty);
        summary.add("samples", tile.sample_count());
    }

    fn summary<T: Transmittance>(
        map: &impl MapTiles<Tile = LayeredPixels<T>>,
    ) -> Result<MapSummary> {
        summary::<Self, T>(map)
    }

    fn contents<T: Transmittance>(tile: &LayeredPixels<T>, pixel: usize) -> PixelContents {
        let mut contents = PixelContents::of_lists("runs", &["depth", "V behind", "samples"]);
        for run in tile.runs(pixel) {
            contents.begin_list();
            for layer in run.layers() {
                contents.push([
                    PixelValue::Number(layer.depth),
                    PixelValue::light(layer.visibility),
                    PixelValue::Count(layer.count),
                ]);
            }
        }
        contents
    }

    /// That of the first run.
    fn function<T: Transmittance>(
        tile: &LayeredPixels<T>,
        pixel: usize,
    ) -> Option<VisibilityView<'_, T>> {
        let first = tile.first_run(pixel);
        Some(first.map_or_else(VisibilityView::clear, |run| run.function()))
    }
}

/// A deep map's answers, by the first run of each pixel.
impl FieldKind for Mtsm {
    type View<'t, T: Transmittance> = &'t LayeredPixels<T>;

    fn view<T: Transmittance>(tile: &LayeredPixels<T>) -> &LayeredPixels<T> {
        tile
    }

    fn evaluate<T: Transmittance>(view: &LayeredPixels<T>, pixel: usize, depth: f32) -> T {
        view.first_run(pixel).map_or(T::CLEAR, |run| run.function().at(depth))
    }
}

impl<T: Transmittance> MultilayerMap<T> {
    /// Reads a whole map into memory, its finest level. O(layers).
    ///
    /// # Errors
    ///
    /// [`Error::Channels`] for a map of another number of channels,
    /// [`Error::Limit`] for one that is too large, or what is wrong with a tile.
    pub fn read(reader: &KindReader<Mtsm>) -> Result<Self> {
        reader.check_in_memory(0)?;
        let metadata = reader.metadata();
        let mut pixels = LayeredPixelsBuilder::new(metadata.width, metadata.height);
        reader.for_each_pixel::<T>(0, |tile, pixel| Ok(pixels.copy_pixel(tile, pixel)?))?;
        let pixels = reader.container().in_file(pixels.finish().map_err(Error::from))?;
        let info = LayeredInfo { map: metadata.info, layering: reader.keys().layering };
        Ok(Self::new(info, pixels))
    }
}
