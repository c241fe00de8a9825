//! Bakes of layered maps into files.

use std::ops::ControlFlow;
use std::path::Path;

use dsm_core::{BakeSettings, HitSource, Progress, Tolerance, Transmittance};
use dsm_io::detail::{BakeReport, Crop, EncodedTile, KindWriter, MapKind, Result, TileId};
use dsm_io::{AchievedError, Codec, Error, Metadata, Packing, WriteOptions};
use dsm_trace::detail::{CutSum, Layering};

use super::keys::LayeredKeys;
use super::layers::Layers;
use super::mtsm::Mtsm;
use crate::build::{BakedLayers, MultilayerBaker};
use crate::multilayer_settings::LayeredInfo;

/// Bakes a multilayer transparent shadow map into a file that replaces `output`,
/// if there is one, with tiles packed as `packing`. `describe` may add to what the
/// map says of itself; `watch` is told before every tile how far the bake has
/// come, and may break it off. The same settings and source give the same bytes,
/// whatever the number of threads. On an error `output` is what it was before.
///
/// # Errors
///
/// [`Error::HitSource`] with what the source says; [`Error::Interrupted`] if
/// `watch` broke it off; else what keeps the file
/// from being written.
pub fn bake_mtsm<T: Transmittance, S: HitSource<T>>(
    baker: &MultilayerBaker<T, S>,
    output: &Path,
    packing: Packing,
    describe: impl FnOnce(&mut Metadata),
    watch: impl Fn(Progress) -> ControlFlow<()> + Sync,
) -> Result<BakeReport>
where
    S::Error: std::error::Error + Send + Sync + 'static,
{
    let settings = &baker.settings().bake;
    let mut file = OpenBake::<Mtsm>::start::<T>(baker.info(), settings, output, describe)?;
    let encode = |tile| BakedTile::encode::<Mtsm, T>(tile, packing).map_err(Failed::Write);
    let outcome = baker.run(encode, |tile| file.write(tile).map_err(Failed::Write), watch);
    file.finish(outcome)
}

/// Bakes a multilayer depth map into a file.
///
/// # Errors
///
/// As [`bake_mtsm`], and for a filter that is not a box of one pixel.
pub fn bake_layers<T: Transmittance, S: HitSource<T>>(
    baker: &MultilayerBaker<T, S>,
    output: &Path,
    packing: Packing,
    describe: impl FnOnce(&mut Metadata),
    watch: impl Fn(Progress) -> ControlFlow<()> + Sync,
) -> Result<BakeReport>
where
    S::Error: std::error::Error + Send + Sync + 'static,
{
    let settings = &baker.settings().bake;
    let mut info = baker.info();
    // Its layers are as they were met, and do not stand in runs.
    info.map.tolerance = Tolerance::EXACT;
    info.layering.resets = 0;
    let mut file = OpenBake::<Layers>::start::<T>(info, settings, output, describe)?;
    let encode = |tile| BakedTile::encode::<Layers, T>(tile, packing).map_err(Failed::Write);
    let outcome = baker.run_depths(encode, |tile| file.write(tile).map_err(Failed::Write), watch);
    file.finish(outcome)
}

/// A baked tile as it is written.
struct BakedTile {
    tile: [u32; 2],
    encoded: EncodedTile,
    error: AchievedError,
    hits: u64,
    cut_pixels: u64,
    most_gained: f64,
    sum_gained: f64,
}

impl BakedTile {
    fn encode<K: MapKind, T: Transmittance>(
        baked: BakedLayers<K::Tile<T>>,
        packing: Packing,
    ) -> Result<Self> {
        let BakedLayers { tile, pixels, max_error, mean_error, hits, cut_pixels, .. } = baked;
        let BakedLayers { most_gained, sum_gained, .. } = baked;
        let encoded = K::encode(&pixels, Codec::Exact, packing)?;
        let error = AchievedError::enclosing(max_error, mean_error);
        Ok(Self { tile, encoded, error, hits, cut_pixels, most_gained, sum_gained })
    }
}

/// A file that a bake writes into.
struct OpenBake<K: MapKind> {
    writer: KindWriter<K>,
    layering: Layering,
    report: BakeReport,
    cut: CutSum,
    /// Column and row of the first tile in the whole map.
    first: [u32; 2],
    is_crop: bool,
}

impl<K: MapKind<Keys = LayeredKeys>> OpenBake<K> {
    fn start<T: Transmittance>(
        mut info: LayeredInfo,
        settings: &BakeSettings,
        output: &Path,
        describe: impl FnOnce(&mut Metadata),
    ) -> Result<Self> {
        // A crop's header is the whole map's.
        info.map.data_window = info.map.display_window;
        let [width, height] = settings.size;
        // 1 or 3.
        let mut metadata = Metadata::new(width, height, T::CHANNELS as u8, info.map);
        describe(&mut metadata);
        let options = WriteOptions::default().with_tile_size(settings.tile_size);
        let crop = settings.crop.map(Crop::of_edges);
        let keys = info.layering.into();
        let writer = KindWriter::create_part(output, metadata, crop, &keys, options)?;
        let [left, top, ..] = settings.crop.unwrap_or_default();
        let first = [left, top].map(|pixel| pixel / settings.tile_size);
        let (layering, report, is_crop) = (info.layering, BakeReport::default(), crop.is_some());
        Ok(Self { writer, layering, report, cut: CutSum::default(), first, is_crop })
    }

    fn write(&mut self, tile: BakedTile) -> Result<()> {
        self.report.hits += tile.hits;
        self.cut.add_tile(tile.cut_pixels, tile.most_gained, tile.sum_gained);
        let [x, y] = [0, 1].map(|axis| tile.tile[axis] - self.first[axis]);
        self.writer.write_encoded(TileId::new(0, x, y), &tile.encoded, tile.error)
    }

    /// Says what the bound of layers left out, if anything.
    fn tell_left_out(&mut self) -> Result<()> {
        let pixels = self.writer.levels()[0].pixel_count();
        let Some(left_out) = self.cut.of_map(pixels, self.is_crop) else { return Ok(()) };
        self.report.cut_pixels = left_out.pixels;
        self.report.gained = [left_out.max, left_out.mean];
        let mut keys = LayeredKeys::from(self.layering);
        keys.left_out = Some(left_out);
        self.writer.set_keys(&keys)
    }

    fn finish<E>(
        mut self,
        outcome: std::result::Result<ControlFlow<()>, Failed<E>>,
    ) -> Result<BakeReport>
    where
        E: std::error::Error + Send + Sync + 'static,
    {
        match outcome {
            Ok(ControlFlow::Continue(())) => {
                self.tell_left_out()?;
                Ok(BakeReport { bytes: self.writer.finish()?, ..self.report })
            }
            Ok(ControlFlow::Break(())) => Err(Error::Interrupted),
            Err(Failed::Write(error)) => Err(error),
            Err(Failed::Source(error)) => Err(Error::HitSource(Box::new(error))),
        }
    }
}

/// Who could not go on.
enum Failed<E> {
    Source(E),
    Write(Error),
}

impl<E> From<E> for Failed<E> {
    fn from(error: E) -> Self {
        Self::Source(error)
    }
}
