//! The conversion itself: rows of a source, compressed tile by tile.

use std::ops::ControlFlow;
use std::ops::Range;
use std::path::Path;

use dsm_core::detail::Quantization;
use dsm_core::{Compression, Progress, Rgb, Side, Tolerance, Transmittance};
use rayon::prelude::*;

use super::camera_reading::CameraConventions;
use super::report::ImportReport;
use super::rows::{ExactFunction, SourceRows};
use super::source::MapSource;
use crate::achieved_error::AchievedError;
use crate::codec::Codec;
use crate::error::{Error, Result};
use crate::format::encoded_tile::EncodedTile;
use crate::measured_pixels::MeasuredPixels;
use crate::progress::{Watch, tell};
use crate::tile_id::TileId;
use crate::write_options::WriteOptions;
use crate::writer::MapWriter;

/// Options of a conversion: the error bound and the storage of the map.
///
/// ```
/// use dsm_io::{Packing, ConvertOptions, WriteOptions};
///
/// let write = WriteOptions::default().with_packing(Packing::Zstd);
/// let options = ConvertOptions { write, ..ConvertOptions::default() };
/// assert_eq!(options.tolerance.epsilon(), 0.0);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ConvertOptions {
    /// The error that the conversion may add. 0 copies.
    pub tolerance: Tolerance,
    /// The storage of the map.
    pub write: WriteOptions,
    /// The conventions of the camera of an image.
    pub cameras: CameraConventions,
    /// The grids that vertices are rounded to, within the tolerance; of codec
    /// `quantized`, and only of that.
    pub quantization: Option<Quantization>,
    /// The compressor, and the side that it keeps to.
    pub compression: Compression,
}

/// Makes a `.dsm` map at `output` from `source`, compressed under the
/// tolerance of `options`. `progress` is told how many rows are done.
///
/// The error that a source `.dsm` states is added to that of every tile, as its
/// tolerance is to the map's, and so is the shift of its depths.
///
/// Memory is bounded by one row of tiles, of the map or of the source; they are
/// compressed in parallel, on the current rayon pool. A tile of which the source
/// holds empty tiles only costs nothing. Tiles of more than readers accept are halved
/// in width and height, all of them, and the report says so. The same input gives the same bytes
/// whatever the number of threads. On an error `output` is what it was before.
///
/// ```
/// use dsm_core::{DeepMap, MapInfo, PixelListsBuilder, Progress, Tolerance, Vertex};
/// use dsm_io::{ConvertOptions, Limits, MapReader, MapSource, Metadata, WriteOptions};
/// use dsm_io::{convert, write_map};
/// # use dsm_io::AchievedError;
///
/// let folder = tempfile::tempdir()?;
/// # let left = 0.5;
/// # let mut path = std::path::PathBuf::new();
/// # for _ in 0..1 {
/// #     let mut pixels = PixelListsBuilder::<f32>::new(1, 1);
/// #     pixels.push(Vertex::new(2.0, 1.0));
/// #     pixels.push(Vertex::new(2.0, left));
/// #     pixels.finish_pixel()?;
/// #     let map = DeepMap::new(MapInfo::default(), pixels.finish()?);
/// #     path = folder.path().join(format!("{left}.dsm"));
/// #     let metadata = Metadata::new(1, 1, 1, MapInfo::default());
/// #     write_map(&path, metadata, &map, AchievedError::NONE, WriteOptions::default())?;
/// # }
/// let mut source = MapSource::open(&path, None, &Limits::default())?;
/// let output = folder.path().join("smaller.dsm");
/// let options = ConvertOptions { tolerance: Tolerance::new(0.01)?, ..ConvertOptions::default() };
/// convert(&mut source, &output, &options, Progress::ignore)?;
/// let map = MapReader::open(&output, &Limits::default())?;
/// assert_eq!(map.metadata().info.tolerance, options.tolerance);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// Whatever is wrong with the source, or keeps the output from being written.
pub fn convert(
    source: &mut MapSource,
    output: &Path,
    options: &ConvertOptions,
    mut progress: impl FnMut(Progress) -> ControlFlow<()>,
) -> Result<ImportReport> {
    let rounds = options.quantization.is_some();
    if rounds != (options.write.codec == Codec::Quantized) {
        return Err(Error::mismatch(
            "grids to round to and a codec for what is rounded go together",
        ));
    }
    if rounds && options.tolerance.epsilon() < Quantization::MIN_TOLERANCE {
        return Err(Error::setting("rounding to grids needs a tolerance of at least 2⁻¹⁶"));
    }
    options.compression.check()?;
    if rounds && options.compression.side == Side::Darker {
        return Err(Error::setting(
            "depths on grids lie behind, where a map is lighter: one that is never lighter is exact",
        ));
    }
    let mut sized = options.clone();
    loop {
        match convert_sized(source, output, &sized, &mut progress) {
            Err(Error::TileTooLarge { .. }) if sized.write.tile_size > 1 => {
                sized.write.tile_size = sized.write.tile_size.div_ceil(2);
            }
            Ok(mut report) if sized != *options => {
                let [asked, size] = [options, &sized].map(|options| options.write.tile_size);
                report.source_notes.push(format!(
                    "tiles of {size} × {size} pixels: readers would not accept what {asked} × \
                     {asked} hold"
                ));
                return Ok(report);
            }
            result => return result,
        }
    }
}

/// Makes a map in tiles of the size that the options have.
fn convert_sized(
    source: &mut MapSource,
    output: &Path,
    options: &ConvertOptions,
    progress: Watch<'_>,
) -> Result<ImportReport> {
    let (mut metadata, mut report) = source.target_metadata(options.tolerance, options.cameras)?;
    metadata.info.compression = options.compression.stated();
    let [width, height] = [metadata.width, metadata.height];
    let channels = metadata.channels;
    let mut writer = MapWriter::create(output, metadata, options.write)?;
    let inherited = source.stated_error();
    let tile_size = options.write.tile_size;
    // Small tiles of a source with large ones: its rows are decoded once.
    let band_rows = tile_size * (source.rows_at_once() / tile_size).max(1);
    for top in (0..height).step_by(band_rows as usize) {
        let rows = top..top.saturating_add(band_rows).min(height);
        let band = Band { width, rows: rows.clone(), options };
        let tiles = if channels == 1 {
            band.compress::<f32>(source)
        } else {
            band.compress::<Rgb>(source)
        }?;
        let depth_error = source.stated_depth_error(rows.clone())?;
        for tile in tiles {
            let achieved = AchievedError {
                max: (inherited.max + tile.achieved.max).min(1.0),
                mean: (inherited.mean + tile.achieved.mean).min(1.0),
            };
            writer.write_encoded(tile.id, &tile.encoded.moved_on(depth_error), achieved)?;
            report += tile.report;
        }
        tell(progress, rows.end, height)?;
    }
    writer.finish()?;
    Ok(report)
}

/// Whole rows of tiles. The first pixel row is that of a tile.
struct Band<'a> {
    width: u32,
    rows: Range<u32>,
    options: &'a ConvertOptions,
}

/// A compressed tile, and how well it fits.
struct CompressedTile {
    id: TileId,
    encoded: EncodedTile,
    achieved: AchievedError,
    report: ImportReport,
}

impl Band<'_> {
    /// Compresses the band's tiles, row by row.
    fn compress<T: Transmittance>(&self, source: &mut MapSource) -> Result<Vec<CompressedTile>> {
        let functions = source.read_rows::<T>(self.rows.clone())?;
        let tile_size = self.options.write.tile_size;
        let columns = self.width.div_ceil(tile_size);
        let first = self.rows.start / tile_size * columns;
        let end = self.rows.end.div_ceil(tile_size) * columns;
        (first..end)
            .into_par_iter()
            .map(|tile| {
                self.compress_tile(&functions, TileId::new(0, tile % columns, tile / columns))
            })
            .collect()
    }

    fn compress_tile<T: Transmittance>(
        &self,
        functions: &SourceRows<'_, T>,
        id: TileId,
    ) -> Result<CompressedTile> {
        let tile_size = self.options.write.tile_size;
        let tile = |index: u32, end: u32| {
            let first = index * tile_size;
            first..first.saturating_add(tile_size).min(end)
        };
        let (columns, rows) = (tile(id.x, self.width), tile(id.y, self.rows.end));
        let mut report = ImportReport::default();
        let from_first = |row: u32| row - self.rows.start;
        if functions.is_clear(columns.clone(), from_first(rows.start)..from_first(rows.end)) {
            let (encoded, achieved) = (EncodedTile::default(), AchievedError::NONE);
            return Ok(CompressedTile { id, encoded, achieved, report });
        }
        let tolerance = self.options.tolerance;
        let size = [columns.len() as u32, rows.len() as u32];
        let quantization = self.options.quantization;
        let mut pixels = MeasuredPixels::<T>::new(size, tolerance, self.options.compression)
            .rounded_to(quantization);
        let mut exact = ExactFunction::new(tolerance.chord());
        for (row, column) in rows.flat_map(|row| columns.clone().map(move |x| (row, x))) {
            let pixel = from_first(row) as usize * self.width as usize + column as usize;
            functions.function(pixel, &mut exact, &mut report)?;
            // Only a curved pixel has spent some of the tolerance on chords;
            // the others may spend all of it here.
            let chord_error = if exact.is_curved() { tolerance.chord() } else { 0.0 };
            pixels.push(exact.vertices(), chord_error)?;
        }
        let depth_error = pixels.depth_error();
        let (pixels, achieved) = pixels.finish()?;
        let write = &self.options.write;
        let encoded = EncodedTile::encode(pixels.view(), write.codec, write.packing)?;
        let encoded = encoded.with_depth_error(depth_error);
        Ok(CompressedTile { id, encoded, achieved, report })
    }
}
