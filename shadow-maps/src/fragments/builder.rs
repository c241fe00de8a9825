//! Builds of maps of fragments.

use std::ops::ControlFlow;

use dsm_core::detail::Result;
use dsm_core::{
    Error, HitSource, PixelSampling, Progress, ShadowCamera, TileHits, TileSamples, Tolerance,
    Transmittance,
};
use dsm_trace::detail::LightFrame;
use rayon::prelude::*;

use super::block_hits::BlockHits;
use super::columns::FragmentColumns;
use super::fragment::Fragment;
use super::groups::{Grouping, SampleGrid};
use super::map::FragmentMap;
use super::media::builder::{BlockMedia, MediaBuilder};
use super::media::columns::MediaColumns;

/// Pixels along the side of what is asked for at once.
pub(super) const TILE: u32 = 16;

/// Builds a [`FragmentMap`] from what a [`HitSource`] shows at 1, 2 × 2, 4 × 4
/// or 8 × 8 places of each pixel, when the shutter is half way or at several times.
///
/// Hits of a pixel that lie in one plane, do not overlap and are equally opaque
/// become one fragment. Hits without a normal, as of strands, face the camera. Media are
/// those along the ray through the pixel's centre, as slabs of constant extinction whose
/// optical depth keeps to a tolerance.
/// What lies at the light's depth or nearer is left out. Every pixel is a
/// function of its own samples: the same on any number of threads.
///
/// ```
/// use dsm_core::{Error, RayHits, RaySource, SamplePoint, ShadowCamera, SurfaceHit};
/// use glam::{DMat4, DVec4};
/// use dsm_trace::detail::LightFrame;
/// use shadow_maps::detail::FragmentBuilder;
///
/// # let to_ndc = DMat4::from_cols(
/// #     DVec4::new(0.5, 0.0, 0.0, 0.0),
/// #     DVec4::new(0.0, -0.5, 0.0, 0.0),
/// #     DVec4::new(-0.5, -0.5, -1.0, -1.0),
/// #     DVec4::ZERO,
/// # );
/// # let camera =
/// #     ShadowCamera { world_to_camera: Some(DMat4::IDENTITY), world_to_ndc: Some(to_ndc) };
/// // An opaque half plane at depth 4 that begins in the middle of pixel 2.
/// let source = RaySource(|point: SamplePoint, ray: &mut RayHits<f32>| -> Result<(), Error> {
///     if point.x > 2.5 {
///         ray.push_surface(SurfaceHit { depth: 4.0, opacity: 1.0 })?;
///     }
///     Ok(())
/// });
/// let builder = FragmentBuilder::new(camera, [4, 4], 0.0)?.with_coverage(8)?;
/// let map = builder.build(&source)?;
/// assert_eq!(map.pixel(1, 0).len(), 0);
/// assert_eq!(map.pixel(2, 0).next().unwrap().coverage, 0xf0f0_f0f0_f0f0_f0f0);
/// # Ok::<(), Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct FragmentBuilder {
    camera: ShadowCamera,
    frame: LightFrame,
    coverage: u32,
    sampling: PixelSampling,
    layers: u32,
    tolerance: Tolerance,
}

/// Counts of the samples and hits that a map of fragments was built from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FragmentCounts {
    /// Surfaces and stretches of media that the samples met.
    pub hits: u64,
    /// Pixels with more fragments than are kept: the rest are one with the last.
    pub cut_pixels: u64,
    /// The most light that any of them lets through too much, to some depth between those
    /// that became one: the mean over the pixel, in [0, 1]. Behind all it is 0.
    pub most_gained: f64,
    /// The same in the mean over all pixels of the map.
    pub mean_gained: f64,
    /// Bounds of the error of each pixel's media, row by row: of the transmittance along the
    /// ray through its centre, up to any depth. None of a source without media.
    pub media_errors: Vec<f32>,
}

/// What a thread builds with; keeps its memory from block to block.
pub(super) struct Scratch<T: Transmittance> {
    hits: TileHits<T>,
    block: BlockHits<T>,
    grouping: Grouping<T>,
    centre_hits: TileHits<T>,
    media: MediaBuilder<T>,
}

impl<T: Transmittance> Scratch<T> {
    pub(super) fn new(tolerance: Tolerance) -> Self {
        Self {
            hits: TileHits::with_normals(0).without_media(),
            block: BlockHits::default(),
            grouping: Grouping::default(),
            centre_hits: TileHits::new(0),
            media: MediaBuilder::new(tolerance),
        }
    }
}

/// The fragments of a block of pixels.
pub(super) struct PixelBlock<T> {
    width: u32,
    fragments: Vec<Fragment<T>>,
    /// Where those of each pixel end.
    ends: Vec<u32>,
    /// None of a source without any.
    media: Option<BlockMedia<T>>,
    pub(super) counts: FragmentCounts,
}

impl FragmentBuilder {
    /// The largest bound of layers a pixel.
    pub const MAX_LAYERS: u32 = 1 << 20;

    /// The tolerance of media: 0.005.
    pub const TOLERANCE: f32 = 0.005;

    /// For a map of `size` pixels that `camera`'s NDC \[0, 1\]² covers, with
    /// the light's centre at `light_depth` on its axis: 8 × 8 places a pixel,
    /// all layers.
    ///
    /// # Errors
    ///
    /// As [`LightFrame::new`].
    pub fn new(camera: ShadowCamera, size: [u32; 2], light_depth: f64) -> Result<Self> {
        let frame = LightFrame::new(&camera, size, light_depth)?;
        let sampling = PixelSampling::grid(8)?;
        let tolerance = Tolerance::new(Self::TOLERANCE)?;
        Ok(Self { camera, frame, coverage: 8, sampling, layers: Self::MAX_LAYERS, tolerance })
    }

    /// Sets the coverage: `side` × `side` places a pixel.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] unless it is 1, 2, 4 or 8.
    pub fn with_coverage(self, side: u32) -> Result<Self> {
        if ![1, 2, 4, 8].contains(&side) {
            return Err(Error::Setting { setting: "coverage", reason: "it must be 1, 2, 4 or 8" });
        }
        Ok(Self { coverage: side, sampling: PixelSampling::grid(side)?, ..self })
    }

    /// Takes the places of the coverage at `times` times all over the shutter, instead of
    /// half way: as many of each pixel at each time, and which is random. What moves then
    /// covers a place of the map with the share of the shutter that it spends there, so that
    /// rays through many places meet it that often. What stands still comes out the same. At
    /// most `times` as many fragments where something moves. Comes after the coverage.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] unless they are 1 to as many as places of a pixel.
    pub fn with_times(self, times: u32, seed: u64) -> Result<Self> {
        Ok(Self { sampling: PixelSampling::grid(self.coverage)?.over_time(times, seed)?, ..self })
    }

    /// Sets the maximum number of fragments a pixel: the nearest to the light are
    /// kept (Xie et al. 2007, §4.2). Where a pixel shows more, the last one stands for the
    /// rest, at the farthest of them: as much light gets past all, and more to what lies
    /// between them ([`FragmentCounts::most_gained`]).
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] for none.
    pub fn with_layers(self, layers: u32) -> Result<Self> {
        if layers == 0 {
            return Err(Error::Setting { setting: "layers", reason: "there must be one or more" });
        }
        Ok(Self { layers: layers.min(Self::MAX_LAYERS), ..self })
    }

    /// Sets the bound of the error of media: of their optical depth along the ray through a
    /// pixel's centre, up to any depth, and so of what is left there. A pixel has at most 256
    /// slabs, and a larger error where these are too few ([`FragmentCounts::media_errors`]).
    #[must_use]
    pub fn with_tolerance(self, tolerance: Tolerance) -> Self {
        Self { tolerance, ..self }
    }

    /// The bound of the error of media.
    #[must_use]
    pub const fn tolerance(&self) -> Tolerance {
        self.tolerance
    }

    /// The camera of the map.
    #[must_use]
    pub const fn camera(&self) -> &ShadowCamera {
        &self.camera
    }

    /// Places along a side of a pixel.
    #[must_use]
    pub const fn coverage(&self) -> u32 {
        self.coverage
    }

    /// The most fragments of a pixel.
    #[must_use]
    pub const fn layers(&self) -> u32 {
        self.layers
    }

    /// The frame of the map.
    #[must_use]
    pub const fn frame(&self) -> &LightFrame {
        &self.frame
    }

    /// Builds the map of all pixels, 32 × 32 at a time, in parallel. O(h log h)
    /// for the h hits of a pixel, and O(o) for a hit with o fragments near it in
    /// depth.
    ///
    /// # Errors
    ///
    /// Those of the source; [`Error::TooLarge`] past 2³² fragments or borders of media.
    pub fn build<T, S>(&self, source: &S) -> std::result::Result<FragmentMap<T>, S::Error>
    where
        T: Transmittance,
        S: HitSource<T>,
    {
        let built = self.build_counted(source, Progress::ignore)?;
        // Nobody breaks it off.
        let (map, _) = built.ok_or(Error::Setting { setting: "build", reason: "broken off" })?;
        Ok(map)
    }

    /// Builds as [`Self::build`] does, and counts. `watch` is told of rows of 32
    /// pixels before each, and may break it off: then there is no map.
    ///
    /// # Errors
    ///
    /// As [`Self::build`].
    pub fn build_counted<T, S>(
        &self,
        source: &S,
        mut watch: impl FnMut(Progress) -> ControlFlow<()>,
    ) -> std::result::Result<Option<(FragmentMap<T>, FragmentCounts)>, S::Error>
    where
        T: Transmittance,
        S: HitSource<T>,
    {
        let [width, height] = self.frame.size();
        let columns = width.div_ceil(TILE);
        let grid = SampleGrid::new(self.coverage, self.frame.footprint(1.0));
        let mut map = FragmentColumns::new();
        let mut media = source.has_media().then(MediaColumns::new);
        let mut counts = FragmentCounts::default();
        let pixels = f64::from(width) * f64::from(height);
        // A row of tiles at a time, so that no more is held twice.
        let rows = u64::from(height.div_ceil(TILE));
        for (row, top) in (0..).zip((0..height).step_by(TILE as usize)) {
            if watch(Progress::new(row, rows)).is_break() {
                return Ok(None);
            }
            let blocks: std::result::Result<Vec<_>, S::Error> = (0..columns)
                .into_par_iter()
                .map_init(
                    || Scratch::new(self.tolerance),
                    |scratch, column| {
                        let min = [column * TILE, top];
                        let size = [width - min[0], height - min[1]].map(|side| side.min(TILE));
                        self.block(source, min, size, &grid, scratch)
                    },
                )
                .collect();
            let blocks = blocks?;
            for block in &blocks {
                counts.hits += block.counts.hits;
                counts.cut_pixels += block.counts.cut_pixels;
                counts.most_gained = counts.most_gained.max(block.counts.most_gained);
                counts.mean_gained += block.counts.mean_gained / pixels;
            }
            for y in 0..TILE.min(height - top) {
                blocks.iter().try_for_each(|block| append(&mut map, block, y))?;
                if let Some(media) = &mut media {
                    let errors = &mut counts.media_errors;
                    blocks.iter().try_for_each(|block| append_media(media, errors, block, y))?;
                }
            }
        }
        let map = FragmentMap::new(self.frame, map)?;
        let map = if let Some(media) = media { map.with_media(media)? } else { map };
        Ok(Some((map, counts)))
    }

    /// The fragments of a block of pixels.
    pub(super) fn block<T, S>(
        &self,
        source: &S,
        min: [u32; 2],
        size: [u32; 2],
        grid: &SampleGrid,
        scratch: &mut Scratch<T>,
    ) -> std::result::Result<PixelBlock<T>, S::Error>
    where
        T: Transmittance,
        S: HitSource<T>,
    {
        let Scratch { hits, block, grouping, centre_hits, media } = scratch;
        let camera = Some((&self.camera, self.frame.size()));
        // Maps have at most 2²⁴ pixels a side.
        let corner = min.map(|side| side as i32);
        let samples = TileSamples::new(&self.sampling, corner, size, camera)?;
        hits.reset(samples.len());
        source.hits(&samples, hits)?;
        block.fill(&self.frame, &samples, hits);
        let mut fragments = Vec::new();
        let mut counts = FragmentCounts { hits: hits.surface_count() as u64, ..Default::default() };
        let per_pixel = samples.samples_per_pixel();
        let ends = (0..size[0] * size[1]).map(|pixel| {
            let hits = block.pixel(pixel * per_pixel, (pixel + 1) * per_pixel);
            let (is_cut, gained) = grouping.append(grid, hits, self.layers, &mut fragments);
            counts.cut_pixels += u64::from(is_cut);
            counts.most_gained = counts.most_gained.max(gained);
            counts.mean_gained += gained;
            fragments.len() as u32
        });
        let ends = ends.collect();
        let mut found = None;
        if source.has_media() {
            let samples = TileSamples::new(&PixelSampling::centre(), corner, size, camera)?;
            centre_hits.reset(samples.len());
            source.hits(&samples, centre_hits)?;
            let block = media.block(&samples, centre_hits, self.frame.light_depth() as f32)?;
            counts.hits += centre_hits.segments().len() as u64;
            found = Some(block);
        }
        Ok(PixelBlock { width: size[0], fragments, ends, media: found, counts })
    }
}

/// Appends row `y` of a block.
pub(super) fn append<T: Transmittance>(
    map: &mut FragmentColumns<T>,
    block: &PixelBlock<T>,
    y: u32,
) -> Result<()> {
    let row = (y * block.width) as usize;
    let mut first = row.checked_sub(1).map_or(0, |before| block.ends[before]);
    for &end in &block.ends[row..row + block.width as usize] {
        map.push_pixel(block.fragments[first as usize..end as usize].iter().copied())?;
        first = end;
    }
    Ok(())
}

/// Appends row `y` of the media of a block.
pub(super) fn append_media<T: Transmittance>(
    map: &mut MediaColumns<T>,
    errors: &mut Vec<f32>,
    block: &PixelBlock<T>,
    y: u32,
) -> Result<()> {
    let Some(media) = &block.media else { return Ok(()) };
    let first = (y * block.width) as usize;
    let mut row = first..first + block.width as usize;
    errors.extend(&media.errors[row.clone()]);
    row.try_for_each(|pixel| map.push_pixel(media.columns.pixel(pixel)))
}
