//! The visibility functions of a block of pixels, before compression.

use super::footprint::Footprint;
use super::pixel_hits::PixelHits;
use super::settings::{BakeSettings, Block};
use crate::curve::surface_sweep::SurfaceSweep;
use crate::curve::sweep::VisibilitySweep;
use crate::curve::transmittance_builder::TransmittanceBuilder;
use crate::curve::transmittance_function::TransmittanceFunction;
use crate::error::Error;
use crate::hits::hit::RayHits;
use crate::hits::hit_source::HitSource;
use crate::hits::tile_hits::TileHits;
use crate::hits::tile_samples::{MapCamera, TileSamples};
use crate::transmittance::Transmittance;
use crate::visibility::vertex::SumVertex;

/// The visibility function of a pixel before compression.
#[derive(Clone, Copy, Debug)]
pub struct ExactPixel<'a, T: Transmittance> {
    pub(super) pixel: [u32; 2],
    pub(super) vertices: &'a [SumVertex<T>],
    pub(super) curved: bool,
}

impl<'a, T: Transmittance> ExactPixel<'a, T> {
    /// Column and row in the map.
    #[must_use]
    pub const fn pixel(&self) -> [u32; 2] {
        self.pixel
    }

    /// The vertices, front to back, as
    /// [`WeightedTransmittance::run`](crate::curve::sweep::WeightedTransmittance::run)
    /// gives them. None: 1 everywhere.
    #[must_use]
    pub const fn vertices(&self) -> &'a [SumVertex<T>] {
        self.vertices
    }

    /// True if chords stand for exponentials, so that the function is off by up to
    /// the chord error already: [`Tolerance::chord`](crate::Tolerance::chord)
    /// unless another was asked for.
    #[must_use]
    pub const fn is_curved(&self) -> bool {
        self.curved
    }
}

/// The weighted hits of the samples under a pixel's filter, before they are summed
/// up.
#[derive(Clone, Copy, Debug)]
pub struct SampledPixel<'a, T: Transmittance> {
    pub(super) pixel: [u32; 2],
    pub(super) weights: &'a [f64],
    pub(super) rays: &'a [RayHits<T>],
}

impl<'a, T: Transmittance> SampledPixel<'a, T> {
    /// Column and row in the map.
    #[must_use]
    pub const fn pixel(&self) -> [u32; 2] {
        self.pixel
    }

    /// The weights of the rays in the pixel filter's sum (Lokovic & Veach 2000,
    /// equation 1): at least 0, 1 in all but for rounding.
    #[must_use]
    pub const fn weights(&self) -> &'a [f64] {
        self.weights
    }

    /// The hits of the rays, in the order of their weights.
    #[must_use]
    pub const fn rays(&self) -> &'a [RayHits<T>] {
        self.rays
    }
}

/// Makes the exact functions of block after block, and keeps its memory in
/// between: hits of the block's samples and of the border that the filter
/// reaches, and, where there are media, the functions of the samples in as
/// many rows as the filter reaches (Lokovic & Veach 2000, §5.1).
#[derive(Debug)]
pub(super) struct ExactBaker<T: Transmittance> {
    samples: TileSamples,
    hits: TileHits<T>,
    pixels: PixelHits<T>,
    footprint: Footprint<T>,
    surfaces: SurfaceSweep<T>,
    media: Media<T>,
    vertices: Vec<SumVertex<T>>,
    rays: Vec<RayHits<T>>,
}

impl<T: Transmittance> ExactBaker<T> {
    pub(super) fn new(settings: &BakeSettings, camera: Option<MapCamera>) -> Self {
        Self {
            samples: TileSamples::empty(camera),
            hits: TileHits::new(0),
            pixels: PixelHits::default(),
            footprint: Footprint::new(settings),
            surfaces: SurfaceSweep::default(),
            media: Media::new(settings),
            vertices: Vec::new(),
            rays: Vec::new(),
        }
    }

    /// Has chords miss exponentials by at most `chord_error` from now on.
    pub(super) fn set_chord_error(&mut self, chord_error: f64) {
        if self.media.chord_error != chord_error {
            self.media.chord_error = chord_error;
            self.media.builder = TransmittanceBuilder::new(chord_error);
        }
    }

    /// Passes the pixels of `block` to `visit`, row by row.
    pub(super) fn run<S: HitSource<T>>(
        &mut self,
        source: &S,
        settings: &BakeSettings,
        block: Block,
        mut visit: impl FnMut(ExactPixel<'_, T>),
    ) -> Result<u64, S::Error> {
        let hits = self.load(source, settings, block)?;
        self.media.start(self.samples.size()[0]);
        for place in block.places() {
            self.vertices.clear();
            let curved = self.pixel(place);
            let pixel = [0, 1].map(|axis| block.min[axis] + place[axis]);
            visit(ExactPixel { pixel, vertices: &self.vertices, curved });
        }
        Ok(hits)
    }

    /// Passes the hits of the samples under the pixels of `block` to `visit`, row
    /// by row.
    pub(super) fn run_rays<S: HitSource<T>>(
        &mut self,
        source: &S,
        settings: &BakeSettings,
        block: Block,
        mut visit: impl FnMut(SampledPixel<'_, T>),
    ) -> Result<u64, S::Error> {
        let hits = self.load(source, settings, block)?;
        let Self { samples, pixels, footprint, rays, .. } = self;
        let mut order = Vec::new();
        for place in block.places() {
            footprint.weigh(place, samples);
            let weights = footprint.weights();
            if rays.len() < weights.len() {
                rays.resize_with(weights.len(), RayHits::default);
            }
            let per_pixel = samples.samples_per_pixel() as usize;
            let under = footprint.pixels(place, samples);
            for (under, rays) in under.zip(rays.chunks_exact_mut(per_pixel)) {
                let mut rays = rays.iter_mut();
                pixels.for_each_ray(under, &mut order, |hits| {
                    if let Some(ray) = rays.next() {
                        std::mem::swap(ray, hits);
                    }
                });
            }
            let pixel = [0, 1].map(|axis| block.min[axis] + place[axis]);
            visit(SampledPixel { pixel, weights, rays: &rays[..weights.len()] });
        }
        Ok(hits)
    }

    /// Asks the source for what the samples of `block` and of the filter's
    /// border meet, and groups it by pixel.
    fn load<S: HitSource<T>>(
        &mut self,
        source: &S,
        settings: &BakeSettings,
        block: Block,
    ) -> Result<u64, S::Error> {
        let border = self.footprint.border();
        // `BakeSettings::check` keeps both far inside the range of i32.
        let min = block.min.map(|first| first as i32 - border as i32);
        let size = block.size.map(|count| count + 2 * border);
        self.samples.fill(&settings.sampling, min, size)?;
        self.hits.reset(self.samples.len());
        source.hits(&self.samples, &mut self.hits)?;
        let count = self.hits.surface_count() as u64;
        let limit = u64::from(u32::MAX);
        if count > limit || self.hits.segments().len() as u64 > limit {
            return Err(Error::TooLarge { what: "hits in one tile", count, limit }.into());
        }
        let hits = count + self.hits.segments().len() as u64;
        self.pixels.group(&mut self.hits, settings.sampling.samples_per_pixel());
        Ok(hits)
    }

    /// Makes the vertices of one pixel of the block, and says whether there
    /// are chords among them.
    fn pixel(&mut self, pixel: [u32; 2]) -> bool {
        let Self { samples, pixels, footprint, surfaces, media, vertices, .. } = self;
        let sink = |vertex| vertices.push(vertex);
        let has_media = pixels.has_media()
            && footprint
                .pixels(pixel, samples)
                .any(|under| !pixels.pixel_segments(under).is_empty());
        if has_media {
            footprint.weigh(pixel, samples);
            media.run(pixel, footprint, samples, pixels, sink)
        } else {
            if let Some(met) = footprint.surfaces(pixel, samples, pixels) {
                surfaces.run(&met, sink);
            }
            false
        }
    }
}

/// Sums up pixels that meet media, from the functions of their samples.
#[derive(Debug)]
struct Media<T: Transmittance> {
    chord_error: f64,
    builder: TransmittanceBuilder<T>,
    sweep: VisibilitySweep<T>,
    /// Scratch memory.
    order: Vec<u32>,
    /// The functions of the pixels under the filter: as many rows as it
    /// reaches, used in turn.
    functions: Vec<TransmittanceFunction<T>>,
    /// The pixel that each entry of `functions` belongs to.
    built: Vec<Option<u32>>,
    rows: u32,
    columns: u32,
}

impl<T: Transmittance> Media<T> {
    fn new(settings: &BakeSettings) -> Self {
        let chord_error = settings.tolerance().chord();
        Self {
            chord_error,
            builder: TransmittanceBuilder::new(chord_error),
            sweep: VisibilitySweep::default(),
            order: Vec::new(),
            functions: Vec::new(),
            built: Vec::new(),
            rows: 2 * settings.border() + 1,
            columns: 0,
        }
    }

    /// Forgets the functions of the last block; this one is `columns` pixels
    /// wide with its border.
    fn start(&mut self, columns: u32) {
        self.columns = columns;
        self.built.clear();
        self.built.resize(columns as usize * self.rows as usize, None);
    }

    fn run(
        &mut self,
        pixel: [u32; 2],
        footprint: &Footprint<T>,
        samples: &TileSamples,
        hits: &PixelHits<T>,
        sink: impl FnMut(SumVertex<T>),
    ) -> bool {
        let per_pixel = samples.samples_per_pixel();
        for under in footprint.pixels(pixel, samples) {
            self.build(under, per_pixel, hits);
        }
        let places = footprint.pixels(pixel, samples).flat_map(|under| {
            let first = self.place(under) * per_pixel as usize;
            first..first + per_pixel as usize
        });
        let functions: Vec<_> = footprint
            .weights()
            .iter()
            .zip(places)
            .map(|(&weight, place)| (weight, &self.functions[place]))
            .collect();
        let sum = self.sweep.over(&functions);
        let curved = sum.is_curved();
        sum.run(sink);
        curved
    }

    /// The index of the functions of a pixel of the block and its border.
    fn place(&self, pixel: u32) -> usize {
        let (row, column) = (pixel / self.columns, pixel % self.columns);
        (row % self.rows * self.columns + column) as usize
    }

    /// Builds the functions of a pixel's samples, unless they are there.
    fn build(&mut self, pixel: u32, per_pixel: u32, hits: &PixelHits<T>) {
        let place = self.place(pixel);
        if self.built[place] == Some(pixel) {
            return;
        }
        self.built[place] = Some(pixel);
        let count = per_pixel as usize;
        let needed = (place + 1) * count;
        if self.functions.len() < needed {
            self.functions.resize_with(needed, TransmittanceFunction::default);
        }
        let functions = &mut self.functions[place * count..needed];
        let mut functions = functions.iter_mut();
        let builder = &mut self.builder;
        hits.for_each_ray(pixel, &mut self.order, |ray| {
            if let Some(function) = functions.next() {
                builder.build(ray, function);
            }
        });
    }
}
