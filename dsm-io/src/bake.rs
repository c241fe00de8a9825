//! Bakes of deep maps into files.

use std::ops::{ControlFlow, Range};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use dsm_core::detail::{
    BakedTile, Compressor, ExactPixel, MipPyramid, SumVertex, VisibilityDifference,
};
use dsm_core::{BakeSettings, Baker, Compression, CompressionMethod, HitSource, Progress, Side};
use dsm_core::{Tolerance, Transmittance, Vertex};

use crate::achieved_error::AchievedError;
use crate::codec::{Codec, Packing};
use crate::crop::Crop;
use crate::error::{Error, Result};
use crate::format::encoded_tile::EncodedTile;
use crate::metadata::Metadata;
use crate::pyramid::build::build_pyramid;
use crate::pyramid::plan::PyramidOptions;
use crate::pyramid::source::{PixelFunctions, PyramidSource, SourceTile};
use crate::tile_id::TileId;
use crate::write_options::WriteOptions;
use crate::writer::MapWriter;

/// Storage of a baked map: codec, packing and mip levels.
///
/// ```
/// use dsm_io::detail::BakeOptions;
/// use dsm_io::{Codec, PyramidOptions};
///
/// let options =
///     BakeOptions::default().with_codec(Codec::Quantized).with_pyramid(Some(PyramidOptions::default()));
/// assert!(options.pyramid.is_some());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct BakeOptions {
    /// The encoding of a tile's columns. Default exact.
    pub codec: Codec,
    /// The packing of the encoded columns. Default zstd.
    pub packing: Packing,
    /// The mip levels to bake as well. Default none.
    pub pyramid: Option<PyramidOptions>,
}

impl Default for BakeOptions {
    fn default() -> Self {
        Self { codec: Codec::Exact, packing: Packing::Zstd, pyramid: None }
    }
}

impl BakeOptions {
    /// Sets the packing of tiles.
    #[must_use]
    pub const fn with_packing(self, packing: Packing) -> Self {
        Self { packing, ..self }
    }

    /// Sets the encoding of tiles.
    #[must_use]
    pub const fn with_codec(self, codec: Codec) -> Self {
        Self { codec, ..self }
    }

    /// Sets the mip levels; `None` bakes level 0 alone.
    #[must_use]
    pub const fn with_pyramid(self, pyramid: Option<PyramidOptions>) -> Self {
        Self { pyramid, ..self }
    }
}

/// Counts of a bake of any kind of map, and the length of its file, as [`bake`]
/// reports them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BakeReport {
    /// Hits of all samples, with those on the borders of tiles that a wide
    /// filter samples again.
    pub hits: u64,
    /// Pixels of which layers were left out, because they had too many: of kinds
    /// that bound them.
    pub cut_pixels: u64,
    /// The most light that one of them lets through too much by that, and the mean over all
    /// pixels, in [0, 1]: where it is known, else 0.
    pub gained: [f32; 2],
    /// Length of the file in bytes.
    pub bytes: u64,
    /// Width and height that tiles were cut down to, because larger ones would have
    /// been more than readers accept.
    pub smaller_tiles: Option<u32>,
}

/// Bakes a map into a file that replaces `output`, if there is one.
///
/// `describe` may add to what the map says of itself; its size, windows,
/// channels and everything that the baker knows are there already. Of a crop
/// the metadata are the whole map's; [`merge`](crate::merge()) puts crops
/// together. `watch` is told before every tile how far the bake has come, from
/// any thread, and may break it off.
///
/// With a pyramid, every level is averaged from the functions before their
/// compression, as far as they lie in one tile, and keeps a tolerance of its
/// own ([`build_pyramid`]); level 0 has the same tiles without one. Where there
/// are media, a coarse level's tolerance may be less than what level 0's chords
/// miss exponentials by: such tiles are baked twice, for level 0 and, with finer
/// chords, for the others. So are all tiles of a map that is rounded, whose
/// coarse levels are not.
///
/// The same settings and source give the same bytes, whatever the number of
/// threads. Memory: that of [`Baker::run`] or of [`build_pyramid`], which holds
/// the uncompressed functions of 4 tiles a thread. On an error `output` is
/// what it was before.
///
/// A tile of more than [`BakeSettings::max_tile_bytes`], which readers would not
/// accept, is given up, and the bake begins again in tiles of half the width and
/// height; the report says so. Of a crop, whose tiles are those of others, it is an
/// error.
///
/// ```
/// use std::ops::ControlFlow;
///
/// use dsm_core::{BakeSettings, Baker, Error, RayHits, RaySource, SamplePoint, SurfaceHit};
/// use dsm_io::detail::{BakeOptions, bake};
/// use dsm_io::{Codec, Limits, MapReader};
///
/// // A pane at depth 2 that takes half of the light.
/// let source = RaySource(|_: SamplePoint, ray: &mut RayHits<f32>| -> Result<(), Error> {
///     ray.push_surface(SurfaceHit { depth: 2.0, opacity: 0.5 })
/// });
/// let baker = Baker::new(source, BakeSettings::new([8, 8])?)?;
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("pane.dsm");
/// let options = BakeOptions::default().with_codec(Codec::Exact);
/// let report = bake(&baker, &path, &options, |_| (), |_| ControlFlow::Continue(()))?;
/// assert_eq!(report.bytes, std::fs::metadata(&path)?.len());
/// let map = MapReader::open(&path, &Limits::default())?.read_map::<f32>(0)?;
/// assert_eq!(map.pixel(4, 4).at(3.0), 0.5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// [`Error::HitSource`] with what the source says; [`Error::Interrupted`] if
/// `watch` broke it off; [`Error::TileTooLarge`]; [`Error::Setting`] for a pyramid of a crop, [`Error::Mismatch`] for a codec
/// that does not fit [`BakeSettings::quantization`]; else what keeps the file from being written.
pub fn bake<T: Transmittance, S: HitSource<T>>(
    baker: &Baker<T, S>,
    output: &Path,
    options: &BakeOptions,
    describe: impl FnOnce(&mut Metadata),
    watch: impl Fn(Progress) -> ControlFlow<()> + Sync,
) -> Result<BakeReport>
where
    S::Error: std::error::Error + Send + Sync + 'static,
{
    let settings = baker.settings();
    if settings.quantization.is_some() != (options.codec == Codec::Quantized) {
        return Err(Error::mismatch(
            "a baker that rounds and a codec for what is rounded go together",
        ));
    }
    let [width, height] = settings.size;
    let mut info = baker.info();
    info.data_window = info.display_window;
    let mut metadata = Metadata::new(width, height, T::CHANNELS as u8, info);
    describe(&mut metadata);
    let mut tile_size = settings.tile_size;
    loop {
        let settings = settings.clone().with_tile_size(tile_size);
        let sized = Baker::new(baker.source(), settings)?;
        match bake_sized(&sized, output, options, metadata.clone(), &watch) {
            // Crops that are put together have tiles of one size.
            Err(Error::TileTooLarge { .. }) if tile_size > 1 && sized.settings().crop.is_none() => {
                tile_size = tile_size.div_ceil(2);
            }
            Err(error) => return Err(error),
            Ok(report) => {
                let is_smaller = tile_size != baker.settings().tile_size;
                let smaller_tiles = is_smaller.then_some(tile_size);
                return Ok(BakeReport { smaller_tiles, ..report });
            }
        }
    }
}

/// Bakes a map in tiles of the size that the baker has.
fn bake_sized<T: Transmittance, S: HitSource<T>>(
    baker: &Baker<T, S>,
    output: &Path,
    options: &BakeOptions,
    metadata: Metadata,
    watch: &(impl Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<BakeReport>
where
    S::Error: std::error::Error + Send + Sync + 'static,
{
    let settings = baker.settings();
    let mut write =
        WriteOptions::default().with_tile_size(settings.tile_size).with_packing(options.packing);
    write.codec = options.codec;
    let mut writer = match settings.crop {
        None => MapWriter::create(output, metadata, write)?,
        Some(crop) => MapWriter::create_crop(output, metadata, Crop::of_edges(crop), write)?,
    };
    let hits = match &options.pyramid {
        None => write_tiles(baker, &mut writer, options, watch)?,
        Some(_) if settings.crop.is_some() => {
            return Err(Error::setting("a part of a map has no pyramid"));
        }
        Some(pyramid) => {
            let tiles = settings.tile_count();
            let source = Exact {
                baker,
                options,
                coarse: CoarseError::new(settings, pyramid),
                watch,
                tiles,
                begun: 0.into(),
                hits: 0.into(),
            };
            build_pyramid(&source, &mut writer, pyramid, Progress::ignore)?;
            source.hits.into_inner()
        }
    };
    Ok(BakeReport { hits, bytes: writer.finish()?, ..BakeReport::default() })
}

/// What a source says; of a tile that was given up that it is too large.
fn failed<T: Transmittance, S: HitSource<T>>(baker: &Baker<T, S>, error: S::Error) -> Error
where
    S::Error: std::error::Error + Send + Sync + 'static,
{
    if baker.has_given_up_a_tile() {
        let limit = baker.settings().max_tile_bytes;
        return Error::TileTooLarge { bytes: limit.saturating_add(1), limit };
    }
    Error::HitSource(Box::new(error))
}

/// Bakes level 0 tile by tile; the number of hits.
fn write_tiles<T: Transmittance, S: HitSource<T>>(
    baker: &Baker<T, S>,
    writer: &mut MapWriter,
    options: &BakeOptions,
    watch: impl Fn(Progress) -> ControlFlow<()> + Sync,
) -> Result<u64>
where
    S::Error: std::error::Error + Send + Sync + 'static,
{
    let [left, top, ..] = baker.settings().window();
    let first = [left, top].map(|pixel| pixel / baker.settings().tile_size);
    let mut hits = 0;
    let encode = |tile: BakedTile<T>| {
        let (encoded, achieved) = encode(&tile, options).map_err(Failed::Write)?;
        Ok((tile.tile(), encoded, achieved, tile.hits()))
    };
    let sink = |([x, y], encoded, achieved, found): ([u32; 2], _, _, u64)| {
        hits += found;
        let id = TileId::new(0, x - first[0], y - first[1]);
        writer.write_encoded(id, &encoded, achieved).map_err(Failed::Write)
    };
    match baker.run(encode, sink, watch) {
        Ok(ControlFlow::Continue(())) => Ok(hits),
        Ok(ControlFlow::Break(())) => Err(Error::Interrupted),
        Err(Failed::Write(error)) => Err(error),
        Err(Failed::Source(error)) => Err(failed(baker, error)),
    }
}

/// A baked tile as it is written.
fn encode<T: Transmittance>(
    tile: &BakedTile<T>,
    options: &BakeOptions,
) -> Result<(EncodedTile, AchievedError)> {
    let mut encoded = EncodedTile::encode(tile.pixels().view(), options.codec, options.packing)?;
    if encoded.codec == Codec::Quantized.tag() {
        encoded.depth_error = tile.depth_error();
    }
    Ok((encoded, AchievedError::enclosing(tile.max_error(), tile.mean_error())))
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

/// A baker's functions before compression.
struct Exact<'a, T: Transmittance, S, W> {
    baker: &'a Baker<T, S>,
    options: &'a BakeOptions,
    coarse: Option<CoarseError>,
    watch: W,
    tiles: u64,
    begun: AtomicU64,
    hits: AtomicU64,
}

/// What media may be off where coarse levels average them, because level 0's
/// chords are too long for that: in all a thirty-second of the least tolerance,
/// half of it for chords.
#[derive(Clone, Copy)]
struct CoarseError {
    chord: f64,
    joined: Tolerance,
}

impl CoarseError {
    fn new(settings: &BakeSettings, pyramid: &PyramidOptions) -> Option<Self> {
        let [width, height] = settings.size;
        let top = MipPyramid::new(width, height).finest(pyramid.levels).level_count() - 1;
        let least = settings.tolerance().of_level(top, pyramid.tolerance_scale);
        let half = f64::from(least.epsilon()) / 64.0;
        let chord = half.max(Tolerance::CHORD_FLOOR);
        let is_finer = top > 0 && chord < settings.tolerance().chord();
        is_finer.then(|| Self { chord, joined: least.after(f64::from(least.epsilon()) - half) })
    }
}

/// The uncompressed functions of a tile.
struct ExactTile<T: Transmittance> {
    vertices: Vec<SumVertex<T>>,
    /// Each pixel's vertices, row by row, and what they are off.
    pixels: Vec<(Range<usize>, f64)>,
}

impl<T: Transmittance> ExactTile<T> {
    /// Joins chords of the vertices from `start` on that are shorter than
    /// they need to be; returns the error of that.
    fn join_chords(&mut self, start: usize, tolerance: Tolerance, compression: Compression) -> f64 {
        let exact = &self.vertices[start..];
        let mut joined: Vec<SumVertex<T>> = Vec::new();
        compression.compressor().compress(tolerance, exact, &mut |vertex: Vertex<T>| {
            joined.push(Vertex::new(vertex.z, vertex.value.to_sum()));
        });
        let error = VisibilityDifference::between(exact, joined.as_slice()).max();
        self.vertices.truncate(start);
        self.vertices.append(&mut joined);
        error
    }
}

impl<T: Transmittance> PixelFunctions<T> for ExactTile<T> {
    type Function<'a>
        = &'a [SumVertex<T>]
    where
        Self: 'a;

    fn function(&self, pixel: usize) -> &[SumVertex<T>] {
        &self.vertices[self.pixels[pixel].0.clone()]
    }

    fn error(&self, pixel: usize) -> f64 {
        self.pixels[pixel].1
    }
}

impl<T, S, W> PyramidSource<T> for Exact<'_, T, S, W>
where
    T: Transmittance,
    S: HitSource<T>,
    S::Error: std::error::Error + Send + Sync + 'static,
    W: Fn(Progress) -> ControlFlow<()> + Sync,
{
    type Functions<'a>
        = ExactTile<T>
    where
        Self: 'a;

    fn tile(&self, id: TileId) -> Result<SourceTile<ExactTile<T>>> {
        let done = self.begun.fetch_add(1, Ordering::Relaxed);
        if (self.watch)(Progress::new(done, self.tiles)).is_break() {
            return Err(Error::Interrupted);
        }
        let settings = self.baker.settings();
        let first = [id.x, id.y].map(|index| index * settings.tile_size);
        let [width, height] =
            [0, 1].map(|axis| (settings.size[axis] - first[axis]).min(settings.tile_size));
        let pixels = vec![(0..0, 0.0); width as usize * height as usize];
        let mut tile = ExactTile { vertices: Vec::new(), pixels };
        let chord = self.coarse.map_or(settings.tolerance().chord(), |coarse| coarse.chord);
        let mut is_curved = false;
        // On either side one pass will do: chords are joined, not left out.
        let joining = match settings.compression.side {
            Side::Both => Compression::new(CompressionMethod::Greedy),
            Side::Lighter | Side::Darker => settings.compression,
        };
        let visit = |pixel: ExactPixel<'_, T>| {
            let start = tile.vertices.len();
            tile.vertices.extend_from_slice(pixel.vertices());
            let mut error = if pixel.is_curved() { chord } else { 0.0 };
            if let Some(coarse) = self.coarse.filter(|_| pixel.is_curved()) {
                error += tile.join_chords(start, coarse.joined, joining);
            }
            is_curved |= pixel.is_curved();
            let [x, y] = [0, 1].map(|axis| (pixel.pixel()[axis] - first[axis]) as usize);
            tile.pixels[y * width as usize + x] = (start..tile.vertices.len(), error);
        };
        let failed = |error| failed(self.baker, error);
        let hits = self.baker.exact_tile_within([id.x, id.y], chord, visit).map_err(failed)?;
        // Level 0's own chords are as long as they are without other levels, and
        // it alone is rounded.
        let is_rounded = settings.quantization.is_some() && !tile.vertices.is_empty();
        let stored = if is_rounded || (self.coarse.is_some() && is_curved) {
            let tile = self.baker.tile([id.x, id.y]).map_err(failed)?;
            Some(encode(&tile, self.options)?)
        } else {
            None
        };
        self.hits.fetch_add(hits, Ordering::Relaxed);
        let functions = (!tile.vertices.is_empty()).then_some(tile);
        Ok(SourceTile { functions, stored })
    }
}
