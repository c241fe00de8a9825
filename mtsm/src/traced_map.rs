//! Maps of layers that shadow rays are traced through: in memory, or tile by tile
//! through a cache.

use std::convert::Infallible;
use std::sync::{Mutex, PoisonError};

use dsm_core::detail::Result;
use dsm_core::{Error, Transmittance};
use dsm_io::detail::{CachedMap, LookupCursor, MapKind};
use dsm_trace::detail::LightFrame;

use crate::depth_layers::{DepthLayers, MultilayerDepthMap};
use crate::layered_pixels::LayeredPixels;
use crate::layers_of_pixel::PixelLayers;
use crate::multilayer_map::MultilayerMap;
use crate::multilayer_settings::LayeredInfo;
use crate::store::keys::LayeredKeys;

pub(crate) mod sealed {
    use dsm_core::Transmittance;

    use crate::layers_of_pixel::PixelLayers;

    /// A map whose pixels are read one by one.
    pub trait Layers: Send + Sync {
        /// Mono or coloured.
        type Value: Transmittance;

        /// Why a pixel cannot be had.
        type Error: std::error::Error + Send + Sync + 'static;

        /// Why a map cannot be traced at all.
        type BuildError: std::error::Error + From<dsm_core::Error> + Send + Sync + 'static;

        /// The pixels of a map or of a tile.
        type Pixels: PixelLayers<Self::Value>;

        /// A thread's way to pixels.
        type Reader<'m>: PixelReader<Pixels = Self::Pixels, Error = Self::Error>
        where
            Self: 'm;

        fn size(&self) -> [u32; 2];

        /// A way to pixels for one thread, which keeps what it found.
        fn reader(&self) -> Self::Reader<'_>;

        /// Hands over the depths of all pixels with layers, in any order.
        fn depth_ranges(
            &self,
            take: impl FnMut([u32; 2], [f32; 2]),
        ) -> Result<(), Self::BuildError>;
    }

    /// A thread's way to pixels.
    pub trait PixelReader {
        type Pixels;
        type Error;

        /// What `look` makes of a pixel; none if it is empty.
        fn with_pixel<R>(
            &self,
            pixel: [u32; 2],
            look: impl FnOnce(&Self::Pixels, usize) -> R,
        ) -> Result<Option<R>, Self::Error>;
    }
}

/// A map of layers that shadow rays can be traced through: a [`MultilayerMap`] or
/// a [`MultilayerDepthMap`] in memory, or a file of either behind a cache
/// ([`CachedLayers`]).
pub trait TracedMap: sealed::Layers {
    /// What the map says of itself.
    fn layered_info(&self) -> &LayeredInfo;
}

/// The frame of a map's light.
pub(crate) fn map_frame<M: TracedMap>(map: &M) -> Result<LightFrame> {
    let info = map.layered_info();
    let camera = info.map.camera.ok_or(Error::Camera("the map has none"))?;
    LightFrame::new(&camera, map.size(), f64::from(info.layering.light_depth))
}

/// Pixels that are in memory.
#[derive(Debug)]
pub struct InMemory<'m, P> {
    pixels: &'m P,
    width: usize,
}

impl<P> sealed::PixelReader for InMemory<'_, P> {
    type Pixels = P;
    type Error = Infallible;

    fn with_pixel<R>(
        &self,
        [x, y]: [u32; 2],
        look: impl FnOnce(&P, usize) -> R,
    ) -> std::result::Result<Option<R>, Infallible> {
        Ok(Some(look(self.pixels, y as usize * self.width + x as usize)))
    }
}

impl<'m, P> InMemory<'m, P> {
    fn depth_ranges<T: Transmittance>(
        pixels: &P,
        [width, height]: [u32; 2],
        mut take: impl FnMut([u32; 2], [f32; 2]),
    ) where
        P: PixelLayers<T>,
    {
        let places = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
        for (pixel, place) in places.enumerate() {
            if let Some(depths) = pixels.depth_range(pixel) {
                take(place, depths);
            }
        }
    }

    const fn new(pixels: &'m P, width: u32) -> Self {
        Self { pixels, width: width as usize }
    }
}

macro_rules! traced_in_memory {
    ($($map:ident of $pixels:ident),*) => {$(
        impl<T: Transmittance> TracedMap for $map<T> {
            fn layered_info(&self) -> &LayeredInfo {
                self.info()
            }
        }

        impl<T: Transmittance> sealed::Layers for $map<T> {
            type Value = T;
            type Error = Infallible;
            type BuildError = Error;
            type Pixels = $pixels<T>;
            type Reader<'m> = InMemory<'m, Self::Pixels>;

            fn size(&self) -> [u32; 2] {
                [self.pixels().width(), self.pixels().height()]
            }

            fn reader(&self) -> Self::Reader<'_> {
                InMemory::new(self.pixels(), self.pixels().width())
            }

            fn depth_ranges(&self, take: impl FnMut([u32; 2], [f32; 2])) -> Result<()> {
                InMemory::depth_ranges::<T>(self.pixels(), self.size(), take);
                Ok(())
            }
        }
    )*};
}

traced_in_memory!(MultilayerMap of LayeredPixels, MultilayerDepthMap of DepthLayers);

/// A file of a map of layers whose tiles are read through a
/// [`TileCache`](dsm_io::detail::TileCache) when rays need them: level 0 of view 0.
///
/// ```no_run
/// use std::sync::Arc;
/// use dsm_io::detail::{KindReader, TileCache};
/// use dsm_io::Limits;
/// use mtsm::detail::{CachedLayers, Mtsm, MultilayerTracer, TraceSettings};
///
/// let cache = TileCache::new(256 << 20);
/// let reader = KindReader::<Mtsm>::open("fur.dsm", &Limits::default())?;
/// let map = CachedLayers::new(cache.insert::<f32, _>(reader)?);
/// let tracer = MultilayerTracer::new(Arc::new(map), TraceSettings::default())?;
/// # Ok::<(), dsm_io::Error>(())
/// ```
#[derive(Debug)]
pub struct CachedLayers<T: Transmittance, K: MapKind> {
    map: CachedMap<T, K>,
    info: LayeredInfo,
    /// Those that nobody uses now.
    idle: Mutex<Vec<LookupCursor<T, K>>>,
}

impl<T: Transmittance, K: MapKind<Keys = LayeredKeys>> CachedLayers<T, K> {
    /// The layers of a cached map, of kind `mtsm` or
    /// `layers`.
    #[must_use]
    pub fn new(map: CachedMap<T, K>) -> Self {
        let reader = map.reader();
        let info = LayeredInfo { map: reader.metadata().info, layering: reader.keys().layering };
        Self { map, info, idle: Mutex::default() }
    }
}

impl<T: Transmittance, K: MapKind> CachedLayers<T, K> {
    /// The map.
    #[must_use]
    pub const fn map(&self) -> &CachedMap<T, K> {
        &self.map
    }
}

impl<T, K> TracedMap for CachedLayers<T, K>
where
    T: Transmittance,
    K: MapKind,
    K::Tile<T>: PixelLayers<T>,
{
    fn layered_info(&self) -> &LayeredInfo {
        &self.info
    }
}

impl<T, K> sealed::Layers for CachedLayers<T, K>
where
    T: Transmittance,
    K: MapKind,
    K::Tile<T>: PixelLayers<T>,
{
    type Value = T;
    type Error = dsm_io::Error;
    type BuildError = dsm_io::Error;
    type Pixels = K::Tile<T>;
    type Reader<'m> = PooledCursor<'m, T, K>;

    fn size(&self) -> [u32; 2] {
        let metadata = self.map.reader().metadata();
        [metadata.width, metadata.height]
    }

    fn reader(&self) -> PooledCursor<'_, T, K> {
        let idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner).pop();
        PooledCursor { cursor: Some(idle.unwrap_or_else(|| self.map.cursor())), pool: &self.idle }
    }

    fn depth_ranges(&self, mut take: impl FnMut([u32; 2], [f32; 2])) -> dsm_io::detail::Result<()> {
        self.map.reader().for_each_tile::<T>(0, |rect, tile| {
            for pixel in 0..rect.width * rect.height {
                if let Some(depths) = tile.depth_range(pixel as usize) {
                    take([rect.x + pixel % rect.width, rect.y + pixel / rect.width], depths);
                }
            }
            Ok(())
        })
    }
}

/// A cursor that goes back into its pool.
#[derive(Debug)]
pub struct PooledCursor<'m, T: Transmittance, K: MapKind> {
    /// None: it was put back.
    cursor: Option<LookupCursor<T, K>>,
    pool: &'m Mutex<Vec<LookupCursor<T, K>>>,
}

impl<T: Transmittance, K: MapKind> sealed::PixelReader for PooledCursor<'_, T, K> {
    type Pixels = K::Tile<T>;
    type Error = dsm_io::Error;

    fn with_pixel<R>(
        &self,
        pixel: [u32; 2],
        look: impl FnOnce(&K::Tile<T>, usize) -> R,
    ) -> dsm_io::detail::Result<Option<R>> {
        let Some(cursor) = &self.cursor else { return Ok(None) };
        cursor.with_pixel(pixel, |tile, pixel| tile.map(|tile| look(tile, pixel)))
    }
}

impl<T: Transmittance, K: MapKind> Drop for PooledCursor<'_, T, K> {
    fn drop(&mut self) {
        if let Some(cursor) = self.cursor.take() {
            self.pool.lock().unwrap_or_else(PoisonError::into_inner).push(cursor);
        }
    }
}
