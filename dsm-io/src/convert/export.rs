//! Exports of maps as deep OpenEXR, a row of tiles at a time.

use std::ops::ControlFlow;
use std::path::Path;

use deep_exr::detail::{Block, ChunkEncoder, EncodedChunk};
use deep_exr::{ChannelType, DeepExrWriter, Layout, SampleType, WriteOptions};
use dsm_core::detail::VisibilityView;
use dsm_core::{Progress, Rgb, Transmittance};
use rayon::prelude::*;

use super::export_options::ExportOptions;
use super::function_samples::FunctionSampler;
use super::image_options::image_options;
use super::rows::SourceRows;
use super::source::MapSource;
use crate::error::{Error, Result};
use crate::format::atomic_file::AtomicFile;
use crate::progress::{Watch, tell};
use crate::region::Region;

/// Counts and errors of an export.
///
/// ```no_run
/// use dsm_core::Progress;
/// use dsm_io::{ExportOptions, ExportReport, Limits, MapSource, export_deep_exr};
///
/// let mut map = MapSource::open("shadow.dsm".as_ref(), None, &Limits::default())?;
/// let (image, options) = ("shadow.exr".as_ref(), ExportOptions::default());
/// let ExportReport { samples, achieved, .. } =
///     export_deep_exr(&mut map, image, &options, Progress::ignore)?;
/// println!("{samples} samples, off by {achieved}");
/// # Ok::<(), dsm_io::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ExportReport {
    /// Samples in the file.
    pub samples: u64,
    /// Samples of the fullest pixel.
    pub max_samples: u32,
    /// The largest difference, at any depth and on both sides of steps,
    /// between the light that the written samples let through and the map.
    /// With 32-bit opacities at most the error that was asked for; 16-bit
    /// ones may take it to 2⁻¹¹.
    pub achieved: f64,
    /// The bound of the file's total error: the tolerance that the map states,
    /// and the requested error or, if larger, the achieved one.
    pub total: f64,
    /// Names of attributes of the map that the file does not have:
    /// `deepImageState`, and those that no OpenEXR can hold.
    pub left_out: Vec<String>,
}

/// Writes level 0 of a map as a deep OpenEXR at `output`. `progress` is told
/// how many rows are done.
///
/// A step becomes a point sample, a ramp a volume; the exponential of a volume
/// is not straight, so that a ramp is cut into as many as keep within the
/// error of `options`. What ends at 0 ends in an opaque point: nothing leaks.
/// Coloured maps have one opacity a colour in `AR`, `AG`, `AB`, and their mean
/// in `A`. The map's windows, camera and attributes are in the file's header.
/// Samples are sorted and don't overlap.
///
/// Memory is bounded by one row of tiles; its pixels are done in parallel, on
/// the current rayon pool. The same input gives the same bytes whatever the
/// number of threads. On an error `output` is what it was before.
///
/// ```no_run
/// use dsm_core::Progress;
/// use dsm_io::{ExportOptions, Limits, MapSource, export_deep_exr};
///
/// let mut map = MapSource::open("shadow.dsm".as_ref(), None, &Limits::default())?;
/// let options = ExportOptions::default();
/// let report = export_deep_exr(&mut map, "shadow.exr".as_ref(), &options, Progress::ignore)?;
/// println!("{} samples, off by {} at most", report.samples, report.total);
/// # Ok::<(), dsm_io::Error>(())
/// ```
///
/// # Errors
///
/// [`Error::Setting`] if the source is an image, or an option is out of range;
/// whatever is wrong with the map, or keeps the output from being written.
pub fn export_deep_exr(
    source: &mut MapSource,
    output: &Path,
    options: &ExportOptions,
    mut progress: impl FnMut(Progress) -> ControlFlow<()>,
) -> Result<ExportReport> {
    export_watched(source, output, options, &mut progress)
}

fn export_watched(
    source: &mut MapSource,
    output: &Path,
    options: &ExportOptions,
    progress: Watch<'_>,
) -> Result<ExportReport> {
    let MapSource::Map(map) = &*source else {
        return Err(Error::setting(
            "an image can't be written as an image: make a .dsm of it first",
        ));
    };
    if options.error.epsilon() < ExportOptions::LEAST_ERROR {
        return Err(Error::setting(format!(
            "the error of an OpenEXR must be at least {:e}",
            ExportOptions::LEAST_ERROR
        )));
    }
    let metadata = map.metadata();
    let tolerance = f64::from(metadata.info.tolerance.epsilon());
    let (image, left_out) = image_options(metadata, options)
        .map_err(|error| Error::from(error).in_file(Some(output)))?;
    // Whole rows of the map's tiles where the image has none: no tile is
    // decoded twice.
    let bands = match options.layout {
        Layout::ScanLines => map.levels()[0].tile_height,
        _ => 1,
    };
    let export = Export {
        image: &image,
        sample_type: options.sample_type,
        error: options.error.epsilon().into(),
        bands,
        sample_bytes: image
            .channels()
            .iter()
            .map(|channel| if channel.channel_type == ChannelType::Half { 2 } else { 4 })
            .sum(),
    };
    let (samples, max_samples, achieved) = if metadata.channels == 1 {
        export.run::<f32>(source, output, progress)
    } else {
        export.run::<Rgb>(source, output, progress)
    }?;
    Ok(ExportReport {
        samples,
        max_samples,
        achieved,
        total: tolerance + achieved.max(options.error.epsilon().into()),
        left_out,
    })
}

struct Export<'a> {
    image: &'a WriteOptions,
    sample_type: SampleType,
    error: f64,
    /// How many rows of blocks are done at once.
    bands: u32,
    /// Bytes of a sample, unpacked.
    sample_bytes: u64,
}

/// A chunk, and what went into it.
struct Chunk {
    block: Block,
    packed: EncodedChunk,
    samples: u64,
    worst: f64,
}

impl Export<'_> {
    /// Writes the file; the number of samples, those of the fullest pixel, and
    /// the largest difference.
    fn run<T: Transmittance>(
        &self,
        source: &mut MapSource,
        output: &Path,
        progress: Watch<'_>,
    ) -> Result<(u64, u32, f64)> {
        let in_output = |error| Error::from(error).in_file(Some(output));
        let mut writer =
            DeepExrWriter::new(AtomicFile::create(output)?, self.image).map_err(in_output)?;
        let grid = writer.grid();
        let (mut samples, mut worst) = (0, 0.0_f64);
        let mut first = 0;
        while first < grid.bands() {
            let end = first.saturating_add(self.bands).min(grid.bands());
            let rows = grid.rows(first).start..grid.rows(end - 1).end;
            let SourceRows::Stored(functions) = source.read_rows::<T>(rows.clone())? else {
                return Err(Error::setting("the source has samples, not functions"));
            };
            let blocks: Vec<Block> = (first..end)
                .flat_map(|band| (0..grid.columns()).map(move |column| grid.block(column, band)))
                .collect();
            let chunks = blocks
                .into_par_iter()
                .map_init(
                    || ChunkEncoder::new(self.image),
                    |encoder, block| self.chunk(encoder, &functions, block),
                )
                .collect::<Result<Vec<_>>>()?;
            for chunk in &chunks {
                writer.write_chunk(&chunk.block, &chunk.packed).map_err(in_output)?;
                samples += chunk.samples;
                worst = worst.max(chunk.worst);
            }
            tell(progress, rows.end, source.size()[1])?;
            first = end;
        }
        let max_samples = writer.max_samples();
        let file = writer.finish().map_err(in_output)?;
        file.commit(&[]).map_err(|error| error.in_file(Some(output)))?;
        Ok((samples, max_samples, worst))
    }

    /// Refuses what the reader of images refuses by default: more samples than it
    /// takes in this pixel, or in the chunk so far.
    fn check_size(&self, [x, y]: [u32; 2], own: usize, of_chunk: usize) -> Result<()> {
        let limits = deep_exr::Limits::default();
        let is_too_large = own as u64 > u64::from(limits.max_samples_per_pixel)
            || self.sample_bytes * of_chunk as u64 > limits.max_chunk_bytes;
        if !is_too_large {
            return Ok(());
        }
        Err(Error::setting(format!(
            "pixel ({x}, {y}) has {own} samples and those of its chunk up to it {of_chunk}, more \
             than readers of images take: a larger --tolerance makes fewer, --exr-layout tiled \
             with a small --tile smaller chunks"
        )))
    }

    /// The chunk of a block.
    fn chunk<T: Transmittance>(
        &self,
        encoder: &mut ChunkEncoder,
        functions: &Region<'_, T>,
        block: Block,
    ) -> Result<Chunk> {
        let mut sampler = FunctionSampler::<T>::new(self.sample_type, self.error);
        let mut rows = self.image.rows(block.width);
        for y in block.y..block.y + block.height {
            for x in block.x..block.x + block.width {
                let function = functions.function(x, y).unwrap_or(VisibilityView::clear());
                let before = rows.sample_count();
                sampler.append(function, &mut rows);
                rows.finish_pixel()?;
                self.check_size([x, y], rows.sample_count() - before, rows.sample_count())?;
            }
        }
        Ok(Chunk {
            block,
            packed: encoder.encode(&rows)?,
            samples: rows.sample_count() as u64,
            worst: sampler.worst(),
        })
    }
}
