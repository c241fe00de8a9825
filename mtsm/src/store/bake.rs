//! From a baker to a file.

use std::ops::ControlFlow;
use std::path::Path;

use dsm_core::{BakeProgress, BakeSettings, HitSource, Tolerance, Transmittance};
use dsm_io::{
    AchievedError, Block, ContainerWriter, EncodedTile, Error, Level, Metadata, Result, TileId,
};

use super::tile::StoredTile;
use super::{LayeredKeys, LayeredKind};
use crate::build::{BakedLayers, MultilayerBaker};
use crate::depth_layers::DepthLayers;
use crate::layered_pixels::LayeredPixels;
use crate::multilayer_settings::LayeredInfo;

/// What a bake into a file made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LayeredReport {
    /// Hits of all samples.
    pub hits: u64,
    /// Pixels of which layers were left out, because they had too many.
    pub cut_pixels: u64,
    /// Length of the file in bytes.
    pub bytes: u64,
}

/// Writes a layered map tile by tile, as [`dsm_io::MapWriter`] a deep one.
pub(super) struct LayeredWriter {
    pub(super) container: ContainerWriter,
    json: Vec<u8>,
}

impl LayeredWriter {
    pub(super) fn create(
        path: &Path,
        kind: LayeredKind,
        metadata: &Metadata,
        keys: LayeredKeys,
        tile_size: u32,
    ) -> Result<Self> {
        let json = metadata.to_json_of(kind.name(), keys)?;
        let tolerance = metadata.info.tolerance.epsilon();
        let mut container = ContainerWriter::create(path)?;
        container.add_level(Level::new(metadata.width, metadata.height, tile_size, tolerance))?;
        Ok(Self { container, json })
    }

    pub(super) fn finish(self) -> Result<u64> {
        self.container.finish(&self.json)
    }
}

/// Bakes a multilayer transparent shadow map into a file that replaces `output`,
/// if there is one, with tiles packed as `block`. `describe` may add to what the
/// map says of itself; `watch` is told before every tile how far the bake has
/// come, and may break it off. The same settings and source give the same bytes,
/// whatever the number of threads. On an error `output` is what it was before.
///
/// # Errors
///
/// [`Error::HitSource`] with what the source says; [`Error::Interrupted`] if
/// `watch` broke it off; [`Error::Setting`] for a crop; else what keeps the file
/// from being written.
pub fn bake_mtsm<T: Transmittance, S: HitSource<T>>(
    baker: &MultilayerBaker<T, S>,
    output: &Path,
    block: Block,
    describe: impl FnOnce(&mut Metadata),
    watch: impl Fn(BakeProgress) -> ControlFlow<()> + Sync,
) -> Result<LayeredReport>
where
    S::Error: std::error::Error + Send + Sync + 'static,
{
    let settings = &baker.settings().bake;
    let mut file = OpenBake::start::<LayeredPixels<T>>(baker.info(), settings, output, describe)?;
    let encode = |tile| BakedTile::encode::<LayeredPixels<T>>(tile, block).map_err(Failed::Write);
    let outcome = baker.run(encode, |tile| file.write(tile).map_err(Failed::Write), watch);
    file.finish(outcome)
}

/// The same of a multilayer depth map.
///
/// # Errors
///
/// As [`bake_mtsm`], and if a pixel has more than one ray.
pub fn bake_layers<T: Transmittance, S: HitSource<T>>(
    baker: &MultilayerBaker<T, S>,
    output: &Path,
    block: Block,
    describe: impl FnOnce(&mut Metadata),
    watch: impl Fn(BakeProgress) -> ControlFlow<()> + Sync,
) -> Result<LayeredReport>
where
    S::Error: std::error::Error + Send + Sync + 'static,
{
    let settings = &baker.settings().bake;
    let mut info = baker.info();
    // Its layers are as they were met, and do not stand in runs.
    info.map.tolerance = Tolerance::EXACT;
    info.layering.resets = 0;
    let mut file = OpenBake::start::<DepthLayers<T>>(info, settings, output, describe)?;
    let encode = |tile| BakedTile::encode::<DepthLayers<T>>(tile, block).map_err(Failed::Write);
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
}

impl BakedTile {
    fn encode<P: StoredTile>(baked: BakedLayers<P>, block: Block) -> Result<Self> {
        let BakedLayers { tile, pixels, max_error, mean_error, hits, cut_pixels } = baked;
        let encoded = pixels.encode(block)?;
        let error = AchievedError::enclosing(max_error, mean_error);
        Ok(Self { tile, encoded, error, hits, cut_pixels })
    }
}

/// A file that a bake writes into.
struct OpenBake {
    writer: LayeredWriter,
    report: LayeredReport,
}

impl OpenBake {
    fn start<P: StoredTile>(
        info: LayeredInfo,
        settings: &BakeSettings,
        output: &Path,
        describe: impl FnOnce(&mut Metadata),
    ) -> Result<Self> {
        if settings.crop.is_some() {
            return Err(Error::Setting("a layered map is baked whole".into()));
        }
        let [width, height] = settings.size;
        // 1 or 3.
        let mut metadata = Metadata::new(width, height, P::CHANNELS as u8, info.map);
        describe(&mut metadata);
        let keys = LayeredKeys { layering: info.layering, coverage: None };
        let writer = LayeredWriter::create(output, P::KIND, &metadata, keys, settings.tile_size)?;
        Ok(Self { writer, report: LayeredReport { hits: 0, cut_pixels: 0, bytes: 0 } })
    }

    fn write(&mut self, tile: BakedTile) -> Result<()> {
        self.report.hits += tile.hits;
        self.report.cut_pixels += tile.cut_pixels;
        let id = TileId::new(0, tile.tile[0], tile.tile[1]);
        self.writer.container.write_tile(id, &tile.encoded, tile.error)
    }

    fn finish<E>(
        self,
        outcome: std::result::Result<ControlFlow<()>, Failed<E>>,
    ) -> Result<LayeredReport>
    where
        E: std::error::Error + Send + Sync + 'static,
    {
        match outcome {
            Ok(ControlFlow::Continue(())) => {
                Ok(LayeredReport { bytes: self.writer.finish()?, ..self.report })
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
