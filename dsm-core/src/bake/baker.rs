//! Bakes of deep shadow maps from a [`HitSource`], tile by tile (Lokovic & Veach
//! 2000, §3).

use std::marker::PhantomData;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use super::exact::{ExactBaker, ExactPixel, SampledPixel};
use super::ordered::in_order;
use super::settings::{BakeSettings, Block};
use super::tile::{BakedTile, TileCompressor};
use crate::camera::map_info::MapInfo;
use crate::camera::pixel_window::PixelWindow;
use crate::error::{Error, Result};
use crate::field::map::DeepMap;
use crate::field::pixel_lists::PixelListsBuilder;
use crate::hits::hit_source::HitSource;
use crate::hits::tile_samples::MapCamera;
use crate::progress::Progress;
use crate::transmittance::Transmittance;

/// Tiles that may be begun and not yet handed over, for each thread.
const WINDOW_PER_THREAD: u64 = 4;

/// A baker of deep shadow maps, tile by tile: samples, hits, transmittance
/// functions, the pixel filter's weighted sum, compression.
///
/// Every tile is a function of the settings and of what the source answers for
/// its own samples and those the filter reaches beyond it: it comes out the
/// same alone, in a crop and in the whole map, on any number of threads. A
/// source that answers sample by sample gives the same pixels in tiles of any
/// size.
///
/// **Cost.** O(h log h) for the h hits under a pixel's filter. Pixels that meet
/// surfaces only are swept straight from their hits, without a function for
/// every sample. Memory: the hits of one block of up to 2¹⁴ samples (2¹⁸ where
/// the filter reaches over its border, and always those of one pixel) a thread,
/// and 4 compressed tiles a thread.
///
/// ```
/// use dsm_core::{BakeSettings, Baker, Error, RayHits, RaySource, SamplePoint, SurfaceHit};
/// use dsm_core::VisibilityField;
///
/// // An opaque half plane that begins in the middle of pixel 2.
/// let source = RaySource(|point: SamplePoint, ray: &mut RayHits<f32>| -> Result<(), Error> {
///     if point.x > 2.5 {
///         ray.push_surface(SurfaceHit { depth: 3.0, opacity: 1.0 })?;
///     }
///     Ok(())
/// });
/// let map = Baker::new(source, BakeSettings::new([4, 4])?)?.map()?;
/// assert_eq!(map.evaluate([1, 0], 3.0), Ok(1.0));
/// assert_eq!(map.evaluate([2, 0], 3.0), Ok(0.5));
/// assert_eq!(map.evaluate([3, 0], 3.0), Ok(0.0));
/// # Ok::<(), Error>(())
/// ```
#[derive(Debug)]
pub struct Baker<T: Transmittance, S> {
    source: S,
    settings: BakeSettings,
    camera: Option<MapCamera>,
    /// Working memory of threads that are between two tiles.
    spare: Mutex<Vec<ExactBaker<T>>>,
    /// Whether a tile was given up because of its size.
    is_too_large: AtomicBool,
    channels: PhantomData<T>,
}

impl<T: Transmittance, S: HitSource<T>> Baker<T, S> {
    /// A baker of the scene behind `source`.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] for settings out of range, and [`Error::Camera`] for
    /// a camera without a matrix.
    pub fn new(source: S, settings: BakeSettings) -> Result<Self> {
        let camera = settings.check()?;
        let (spare, is_too_large) = (Mutex::default(), AtomicBool::new(false));
        Ok(Self { source, settings, camera, spare, is_too_large, channels: PhantomData })
    }

    /// The source of hits.
    #[must_use]
    pub const fn source(&self) -> &S {
        &self.source
    }

    /// Whether a tile was given up because it takes more than
    /// [`BakeSettings::max_tile_bytes`]: smaller tiles may not.
    #[must_use]
    pub fn has_given_up_a_tile(&self) -> bool {
        self.is_too_large.load(Ordering::Relaxed)
    }

    /// The settings.
    #[must_use]
    pub const fn settings(&self) -> &BakeSettings {
        &self.settings
    }

    /// The metadata of the map.
    #[must_use]
    pub fn info(&self) -> MapInfo {
        let [left, top, right, bottom] = self.settings.window();
        // Sizes lie below 2²⁴.
        let window = |[left, top, right, bottom]: [u32; 4]| PixelWindow {
            min: [left as i32, top as i32],
            max: [right as i32 - 1, bottom as i32 - 1],
        };
        let [width, height] = self.settings.size;
        MapInfo {
            camera: self.settings.camera,
            tolerance: self.settings.tolerance(),
            compression: self.settings.compression.stated(),
            samples: Some(self.settings.sampling.samples_per_pixel()),
            filter: Some(self.settings.filter),
            data_window: Some(window([left, top, right, bottom])),
            display_window: Some(window([0, 0, width, height])),
            ..MapInfo::default()
        }
    }

    /// Passes the uncompressed visibility functions of a tile's pixels to `visit`:
    /// each pixel once, row by row or, in a tile of several blocks, block by block.
    /// Returns the number of hits.
    ///
    /// # Errors
    ///
    /// Those of the source, [`Error::Setting`] for a tile outside the map,
    /// [`Error::TooLarge`] if a block has 2³² hits.
    pub fn exact_tile(
        &self,
        tile: [u32; 2],
        visit: impl FnMut(ExactPixel<'_, T>),
    ) -> std::result::Result<u64, S::Error> {
        self.exact_tile_within(tile, self.settings.tolerance().chord(), visit)
    }

    /// Passes the functions of [`Self::exact_tile`] to `visit` with a chord error
    /// of its own: chords miss the exponentials of media by at most `chord_error`,
    /// or [`Tolerance::CHORD_FLOOR`](crate::Tolerance::CHORD_FLOOR) if that is
    /// more.
    ///
    /// # Errors
    ///
    /// As [`Self::exact_tile`].
    pub fn exact_tile_within(
        &self,
        tile: [u32; 2],
        chord_error: f64,
        mut visit: impl FnMut(ExactPixel<'_, T>),
    ) -> std::result::Result<u64, S::Error> {
        self.with_blocks(tile, |baker, block| {
            baker.set_chord_error(chord_error);
            baker.run(&self.source, &self.settings, block, &mut visit)
        })
    }

    /// Passes the weighted hits of the samples under each pixel's filter to
    /// `visit`, each pixel once, in the order of [`Self::exact_tile`]: for maps
    /// that keep more of them than one function a pixel. Returns the number of
    /// hits. Costs O(h log h) for the h hits under a filter, and holds those of one
    /// pixel's samples a second time.
    ///
    /// # Errors
    ///
    /// As [`Self::exact_tile`].
    pub fn sampled_tile(
        &self,
        tile: [u32; 2],
        mut visit: impl FnMut(SampledPixel<'_, T>),
    ) -> std::result::Result<u64, S::Error> {
        self.with_blocks(tile, |baker, block| {
            baker.run_rays(&self.source, &self.settings, block, &mut visit)
        })
    }

    /// Cuts a tile into blocks and adds up the hits that `run` finds in them.
    fn with_blocks(
        &self,
        tile: [u32; 2],
        mut run: impl FnMut(&mut ExactBaker<T>, Block) -> std::result::Result<u64, S::Error>,
    ) -> std::result::Result<u64, S::Error> {
        let block = self.settings.tile_pixels(tile);
        if block.size.contains(&0) {
            let reason = "the tile lies outside the map";
            return Err(Error::Setting { setting: "tile", reason }.into());
        }
        let spare = self.spare.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let mut baker = spare.unwrap_or_else(|| ExactBaker::new(&self.settings, self.camera));
        let mut hits = 0;
        let baked = block.split(&self.settings, &mut |block| {
            hits += run(&mut baker, block)?;
            Ok(())
        });
        self.spare.lock().unwrap_or_else(PoisonError::into_inner).push(baker);
        baked.map(|()| hits)
    }

    /// Bakes one tile.
    ///
    /// # Errors
    ///
    /// As [`Self::exact_tile`], and [`Error::TooLarge`] for a tile of more than
    /// [`BakeSettings::max_tile_bytes`], after the first block that is past them.
    pub fn tile(&self, tile: [u32; 2]) -> std::result::Result<BakedTile<T>, S::Error> {
        let block = self.settings.tile_pixels(tile);
        let settings = &self.settings;
        let mut compressor = TileCompressor::new(
            settings.tolerance(),
            settings.quantization,
            settings.compression,
            block,
        );
        let hits = self.with_blocks(tile, |baker, block| {
            let limit = self.settings.max_tile_bytes;
            let count = compressor.least_bytes();
            if count > limit {
                self.is_too_large.store(true, Ordering::Relaxed);
                return Err(Error::TooLarge { what: "bytes of a tile", count, limit }.into());
            }
            baker.set_chord_error(self.settings.tolerance().chord());
            baker.run(&self.source, &self.settings, block, &mut |pixel: ExactPixel<'_, T>| {
                compressor.push(pixel);
            })
        })?;
        Ok(compressor.finish(tile, hits)?)
    }

    /// Bakes all tiles, in parallel on the current rayon pool. `encode` makes
    /// of each tile what is written of it, in parallel as well; `sink` is given
    /// that in order, row by row ([`BakeSettings::tiles`]), from any thread but
    /// one tile at a time. `watch` is told how far it has come before every
    /// tile, from any thread, and may break it off: no later tile is handed
    /// over then, and the answer is a break.
    ///
    /// # Errors
    ///
    /// The first in order of the tiles, from the source, `encode` or `sink`.
    /// No later tile is handed over.
    pub fn run<U: Send, E: From<S::Error> + Send>(
        &self,
        encode: impl Fn(BakedTile<T>) -> std::result::Result<U, E> + Sync,
        sink: impl FnMut(U) -> std::result::Result<(), E> + Send,
        watch: impl Fn(Progress) -> ControlFlow<()> + Sync,
    ) -> std::result::Result<ControlFlow<()>, E> {
        self.run_tiles(|tile| encode(self.tile(tile)?), sink, watch)
    }

    /// Makes tiles of any kind, in parallel and in the order of [`Self::run`]:
    /// `make` makes one of its place among the tiles of the whole map.
    ///
    /// # Errors
    ///
    /// The first in order of the tiles, from `make` or `sink`.
    pub fn run_tiles<U: Send, E: Send>(
        &self,
        make: impl Fn([u32; 2]) -> std::result::Result<U, E> + Sync,
        mut sink: impl FnMut(U) -> std::result::Result<(), E> + Send,
        watch: impl Fn(Progress) -> ControlFlow<()> + Sync,
    ) -> std::result::Result<ControlFlow<()>, E> {
        let tiles = self.settings.tile_count();
        let done = AtomicU64::new(0);
        let window = WINDOW_PER_THREAD * rayon::current_num_threads() as u64;
        in_order(
            tiles,
            window,
            |index| {
                let progress = Progress::new(done.load(Ordering::Relaxed), tiles);
                if watch(progress).is_break() {
                    return Ok(ControlFlow::Break(()));
                }
                make(self.settings.tile(index)).map(ControlFlow::Continue)
            },
            |encoded| {
                sink(encoded)?;
                done.fetch_add(1, Ordering::Relaxed);
                Ok(())
            },
        )
    }

    /// Bakes a map in memory: the crop, if there is one.
    ///
    /// # Errors
    ///
    /// As [`Self::exact_tile`], and [`Error::TooLarge`] past 2³² − 1 values.
    pub fn map(&self) -> std::result::Result<DeepMap<T>, S::Error> {
        let [left, top, right, bottom] = self.settings.window();
        let mut row: Vec<BakedTile<T>> = Vec::new();
        let mut lists = PixelListsBuilder::new(right - left, bottom - top);
        let columns =
            (right.div_ceil(self.settings.tile_size) - left / self.settings.tile_size) as usize;
        let sink = |tile| {
            row.push(tile);
            if row.len() == columns {
                let tiles: Vec<_> = row.iter().map(|tile| tile.pixels.view()).collect();
                for y in 0..tiles.first().map_or(0, |tile| tile.height()) {
                    for tile in &tiles {
                        for x in 0..tile.width() {
                            tile.pixel(x, y).vertices().for_each(|vertex| lists.push(vertex));
                            lists.finish_pixel()?;
                        }
                    }
                }
                row.clear();
            }
            Ok(())
        };
        let never = |_| ControlFlow::Continue(());
        self.run::<_, S::Error>(Ok, sink, never).map(drop)?;
        Ok(DeepMap::new(self.info(), lists.finish()?))
    }
}
