//! Bakes of the tiles of multilayer transparent shadow maps (Xie, Tabellion &
//! Pearce 2007, §5.1).

use std::ops::{ControlFlow, Range};
use std::sync::{Mutex, PoisonError};

use dsm_core::detail::{Result, SampledPixel};
use dsm_core::{Baker, Error, HitSource, Progress, SurfaceHit, Transmittance};
use dsm_io::detail::RowOrder;
use dsm_trace::detail::LightFrame;

use crate::depth_layers::{DepthLayers, MultilayerDepthMap};
use crate::layer::Layer;
use crate::layered_pixels::{LayeredPixels, LayeredPixelsBuilder};
use crate::mean_layers::MeanLayers;
use crate::multilayer_map::MultilayerMap;
use crate::multilayer_settings::{LayeredInfo, MultilayerSettings};
use crate::run_builder::RunBuilder;

/// Bakes multilayer transparent shadow maps: the construction of deep shadow
/// maps, with the number of samples between layers, and with runs. Where the
/// light left in a pixel comes to 0 (an eighth of the tolerance is as good as
/// 0), the run ends at exactly 0, and the next one starts with light of 1 for
/// all of the pixel's rays, just behind that depth.
///
/// Within each run every layer keeps the tolerance: |V′ − V| ≤ ε at every depth
/// up to the run's end, where V is the weighted sum of the rays' transmittance
/// from the run's start on.
///
/// A *sample* is a place where the transmittance of one of the pixel's rays
/// falls: its surfaces at one depth, or a chord of a medium. What is behind
/// something opaque, within a run, counts for nothing. The counts of layers that
/// compression removes are added to the layer behind them.
///
/// **Cost.** O(runs · h log h) for the h hits under a pixel's filter.
///
/// ```
/// use dsm_core::{Error, RayHits, RaySource, SamplePoint, SurfaceHit};
/// use mtsm::{MultilayerBaker, MultilayerSettings};
///
/// // Behind an opaque leaf, a second run holds the wall.
/// let source = RaySource(|_: SamplePoint, ray: &mut RayHits<f32>| -> Result<(), Error> {
///     ray.push_surface(SurfaceHit { depth: 2.0, opacity: 1.0 })?;
///     ray.push_surface(SurfaceHit { depth: 5.0, opacity: 1.0 })
/// });
/// let map = MultilayerBaker::new(source, MultilayerSettings::new([4, 4])?)?.map()?;
/// assert_eq!(map.pixels().runs(0).len(), 2);
/// # Ok::<(), Error>(())
/// ```
#[derive(Debug)]
pub struct MultilayerBaker<T: Transmittance, S> {
    baker: Baker<T, S>,
    settings: MultilayerSettings,
    /// What threads that are between two tiles have left here.
    spare: Mutex<Vec<RunBuilder<T>>>,
}

/// A tile of layers that was baked.
#[derive(Clone, Debug, PartialEq)]
pub struct BakedLayers<P> {
    /// Column and row among the tiles of the map.
    pub tile: [u32; 2],
    /// The tile's pixels.
    pub pixels: P,
    /// The largest error of any run, measured in `f64` on the `f32` values
    /// before layers above the most were left out.
    pub max_error: f64,
    /// The mean of the pixels' mean errors.
    pub mean_error: f64,
    /// Number of surfaces and stretches of media that its samples met.
    pub hits: u64,
    /// Pixels of which layers were left out, because they had too many.
    pub cut_pixels: u64,
    /// The most light that is too much behind the layers that are left of one of them, in
    /// [0, 1].
    pub most_gained: f64,
    /// The same of all of them, added up.
    pub sum_gained: f64,
}

impl<T: Transmittance, S: HitSource<T>> MultilayerBaker<T, S> {
    /// A baker of what `source` shows.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] for settings out of range, and [`Error::Camera`] for a camera
    /// that shadow rays could not be traced with ([`LightFrame::new`]). A map without
    /// any can only be filtered.
    pub fn new(source: S, settings: MultilayerSettings) -> Result<Self> {
        settings.check()?;
        let MultilayerSettings { bake, light_depth, .. } = &settings;
        if let Some(camera) = &bake.camera {
            LightFrame::new(camera, bake.size, f64::from(*light_depth))?;
        }
        let baker = Baker::new(source, settings.bake.clone())?;
        Ok(Self { baker, settings, spare: Mutex::default() })
    }

    /// The settings.
    #[must_use]
    pub const fn settings(&self) -> &MultilayerSettings {
        &self.settings
    }

    /// The metadata of the map.
    #[must_use]
    pub fn info(&self) -> LayeredInfo {
        self.settings.info(self.baker.info())
    }

    /// Bakes one tile.
    ///
    /// # Errors
    ///
    /// As [`Baker::sampled_tile`].
    pub fn tile(
        &self,
        tile: [u32; 2],
    ) -> std::result::Result<BakedLayers<LayeredPixels<T>>, S::Error> {
        let spare = self.spare.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let builder = spare.unwrap_or_else(|| RunBuilder::new(&self.settings));
        let mut pixels = TileRuns::new(builder, tile_block(&self.settings.bake, tile));
        let baked = self.baker.sampled_tile(tile, |pixel| pixels.push(&pixel));
        let tile = baked.and_then(|hits| Ok(pixels.finish(tile, hits)?));
        self.spare.lock().unwrap_or_else(PoisonError::into_inner).push(pixels.builder);
        tile
    }

    /// Bakes all tiles, in parallel and in order, as [`Baker::run`] does.
    ///
    /// # Errors
    ///
    /// As [`Baker::run`].
    pub fn run<U: Send, E: From<S::Error> + Send>(
        &self,
        encode: impl Fn(BakedLayers<LayeredPixels<T>>) -> std::result::Result<U, E> + Sync,
        sink: impl FnMut(U) -> std::result::Result<(), E> + Send,
        watch: impl Fn(Progress) -> ControlFlow<()> + Sync,
    ) -> std::result::Result<ControlFlow<()>, E> {
        self.baker.run_tiles(|tile| encode(self.tile(tile)?), sink, watch)
    }

    /// Bakes one tile of a multilayer depth map (§4.2): of each pixel the
    /// nearest surfaces that its ray meets, by insertion. Media are left out. Of several
    /// rays, as of one at several times, layers let through the mean up to any depth:
    /// O(h log h) for the h surfaces of a pixel.
    ///
    /// # Errors
    ///
    /// As [`Baker::sampled_tile`], and [`Error::Setting`] for a filter that is not a box of
    /// one pixel.
    pub fn depth_tile(
        &self,
        tile: [u32; 2],
    ) -> std::result::Result<BakedLayers<DepthLayers<T>>, S::Error> {
        let bake = &self.settings.bake;
        if !bake.filter.is_pixel() {
            let reason = "layers are those of one pixel's own rays: a box of width 1";
            return Err(Error::Setting { setting: "filter", reason }.into());
        }
        let [min, [width, height]] = tile_block(bake, tile);
        // Pixels come in any order.
        let mut lists = vec![0..0; width as usize * height as usize];
        let mut surfaces = Vec::new();
        let mut mean = MeanLayers::new();
        let is_seen = |hit: &&SurfaceHit<T>| hit.depth > self.settings.light_depth;
        let hits = self.baker.sampled_tile(tile, |pixel| {
            let [x, y] = [0, 1].map(|axis| (pixel.pixel()[axis] - min[axis]) as usize);
            let start = surfaces.len();
            match pixel.rays() {
                [ray] => surfaces.extend(ray.surfaces().iter().filter(is_seen).copied()),
                rays => {
                    let met = rays.iter().map(|ray| ray.surfaces().iter().filter(is_seen));
                    mean.append(met, &mut surfaces);
                }
            }
            lists[y * width as usize + x] = start..surfaces.len();
        })?;
        let mut pixels = DepthLayers::clear(width, height, self.settings.max_layers);
        let most = self.settings.max_layers as usize;
        let (mut cut_pixels, mut most_gained, mut sum_gained) = (0, 0.0_f64, 0.0);
        for list in lists {
            if list.len() > most {
                cut_pixels += 1;
                let gained = stopped_behind(&mut surfaces[list.clone()], most);
                most_gained = most_gained.max(gained);
                sum_gained += gained;
            }
            surfaces[list].iter().for_each(|&hit| pixels.insert(hit));
            pixels.finish_pixel()?;
        }
        let (max_error, mean_error) = (0.0, 0.0);
        Ok(BakedLayers {
            tile,
            pixels,
            max_error,
            mean_error,
            hits,
            cut_pixels,
            most_gained,
            sum_gained,
        })
    }

    /// Bakes all tiles of a multilayer depth map, as [`Self::run`] does.
    ///
    /// # Errors
    ///
    /// As [`Self::run`] and [`Self::depth_tile`].
    pub fn run_depths<U: Send, E: From<S::Error> + Send>(
        &self,
        encode: impl Fn(BakedLayers<DepthLayers<T>>) -> std::result::Result<U, E> + Sync,
        sink: impl FnMut(U) -> std::result::Result<(), E> + Send,
        watch: impl Fn(Progress) -> ControlFlow<()> + Sync,
    ) -> std::result::Result<ControlFlow<()>, E> {
        self.baker.run_tiles(|tile| encode(self.depth_tile(tile)?), sink, watch)
    }

    /// Bakes a multilayer depth map in memory: the crop, if there is one.
    ///
    /// # Errors
    ///
    /// As [`Self::run_depths`].
    pub fn depth_map(&self) -> std::result::Result<MultilayerDepthMap<T>, S::Error> {
        let [left, top, right, bottom] = self.settings.bake.window();
        let mut rows = RowOrder::new(self.tile_columns());
        let mut pixels = DepthLayers::clear(right - left, bottom - top, self.settings.max_layers);
        let sink = |tile: BakedLayers<DepthLayers<T>>| {
            Ok(rows.push(tile.pixels, |tile, pixel| pixels.copy_pixel(tile, pixel))?)
        };
        let never = |_| ControlFlow::Continue(());
        self.run_depths::<_, S::Error>(Ok, sink, never).map(drop)?;
        Ok(MultilayerDepthMap::new(self.info(), pixels))
    }

    /// Tiles in a row of what is baked.
    fn tile_columns(&self) -> usize {
        let [left, _, right, _] = self.settings.bake.window();
        let tile_size = self.settings.bake.tile_size;
        (right.div_ceil(tile_size) - left / tile_size) as usize
    }

    /// Bakes a map in memory: the crop, if there is one.
    ///
    /// # Errors
    ///
    /// As [`Baker::map`].
    pub fn map(&self) -> std::result::Result<MultilayerMap<T>, S::Error> {
        let [left, top, right, bottom] = self.settings.bake.window();
        let mut rows = RowOrder::new(self.tile_columns());
        let mut pixels = LayeredPixelsBuilder::new(right - left, bottom - top);
        let sink = |tile: BakedLayers<LayeredPixels<T>>| {
            Ok(rows.push(tile.pixels, |tile, pixel| pixels.copy_pixel(tile, pixel))?)
        };
        let never = |_| ControlFlow::Continue(());
        self.run::<_, S::Error>(Ok, sink, never).map(drop)?;
        Ok(MultilayerMap::new(self.info(), pixels.finish()?))
    }
}

/// How much of the light those of these surfaces stop that lie behind the nearest `kept`, in
/// the channel where that is most. Sorts them.
fn stopped_behind<T: Transmittance>(surfaces: &mut [SurfaceHit<T>], kept: usize) -> f64 {
    surfaces.sort_by(|a, b| a.depth.total_cmp(&b.depth));
    let passes = |some: &[SurfaceHit<T>], channel: usize| -> f64 {
        some.iter().map(|hit| 1.0 - f64::from(hit.opacity.channel(channel))).product()
    };
    let (nearest, rest) = surfaces.split_at(kept);
    let stopped = |channel| passes(nearest, channel) * (1.0 - passes(rest, channel));
    (0..T::CHANNELS).map(stopped).fold(0.0, f64::max)
}

/// First pixel and size of a tile.
pub(crate) fn tile_block(settings: &dsm_core::BakeSettings, tile: [u32; 2]) -> [[u32; 2]; 2] {
    let min = tile.map(|index| index.saturating_mul(settings.tile_size));
    let size =
        [0, 1].map(|axis| settings.size[axis].saturating_sub(min[axis]).min(settings.tile_size));
    [min, size]
}

/// The runs of a tile's pixels, in any order.
struct TileRuns<T: Transmittance> {
    builder: RunBuilder<T>,
    min: [u32; 2],
    size: [u32; 2],
    layers: Vec<Layer<T>>,
    runs: Vec<Range<usize>>,
    /// Each pixel's runs, row by row.
    pixels: Vec<Range<usize>>,
    max_error: f64,
    mean_errors: f64,
    cut_pixels: u64,
    most_gained: f64,
    sum_gained: f64,
}

impl<T: Transmittance> TileRuns<T> {
    fn new(builder: RunBuilder<T>, [min, size]: [[u32; 2]; 2]) -> Self {
        let pixels = vec![0..0; size[0] as usize * size[1] as usize];
        Self {
            builder,
            min,
            size,
            layers: Vec::new(),
            runs: Vec::new(),
            pixels,
            max_error: 0.0,
            mean_errors: 0.0,
            cut_pixels: 0,
            most_gained: 0.0,
            sum_gained: 0.0,
        }
    }

    fn push(&mut self, pixel: &SampledPixel<'_, T>) {
        let [x, y] = [0, 1].map(|axis| (pixel.pixel()[axis] - self.min[axis]) as usize);
        let built = self.builder.build(pixel);
        let first = self.runs.len();
        for run in built.runs() {
            let start = self.layers.len();
            self.layers.extend_from_slice(run);
            self.runs.push(start..self.layers.len());
        }
        self.pixels[y * self.size[0] as usize + x] = first..self.runs.len();
        self.max_error = self.max_error.max(built.max_error);
        self.mean_errors += built.mean_error;
        self.cut_pixels += u64::from(built.is_cut);
        self.most_gained = self.most_gained.max(built.gained);
        self.sum_gained += built.gained;
    }

    fn finish(
        &self,
        tile: [u32; 2],
        hits: u64,
    ) -> std::result::Result<BakedLayers<LayeredPixels<T>>, Error> {
        let mut pixels = LayeredPixelsBuilder::new(self.size[0], self.size[1]);
        for runs in &self.pixels {
            for run in &self.runs[runs.clone()] {
                pixels.push_run(self.layers[run.clone()].iter().copied())?;
            }
            pixels.finish_pixel()?;
        }
        let mean = self.mean_errors / self.pixels.len().max(1) as f64;
        Ok(BakedLayers {
            tile,
            pixels: pixels.finish()?,
            max_error: self.max_error,
            mean_error: mean.min(self.max_error),
            hits,
            cut_pixels: self.cut_pixels,
            most_gained: self.most_gained,
            sum_gained: self.sum_gained,
        })
    }
}
