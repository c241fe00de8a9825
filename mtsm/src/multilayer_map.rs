//! Multilayer transparent shadow maps in memory.

use dsm_core::detail::Result;
use dsm_core::{DeepMap, PixelListsBuilder, Transmittance, VisibilityField};

use crate::layered_pixels::LayeredPixels;
use crate::multilayer_settings::LayeredInfo;

/// A multilayer transparent shadow map (Xie, Tabellion & Pearce 2007, §5).
///
/// It is a deep shadow map still: as a [`VisibilityField`] it answers with the
/// first run of each pixel, so that [`dsm_core::filtered_lookup`] serves it.
///
/// ```
/// use dsm_core::{Error, RayHits, RaySource, SamplePoint, SurfaceHit, VisibilityField};
/// use mtsm::{MultilayerBaker, MultilayerSettings};
///
/// // A leaf in front of a wall.
/// let source = RaySource(|_: SamplePoint, ray: &mut RayHits<f32>| -> Result<(), Error> {
///     for depth in [2.0, 5.0] {
///         ray.push_surface(SurfaceHit { depth, opacity: 1.0 })?;
///     }
///     Ok(())
/// });
/// let map = MultilayerBaker::new(source, MultilayerSettings::new([4, 4])?)?.map()?;
/// assert_eq!(map.pixels().runs(0).len(), 2);
/// assert_eq!(map.evaluate([0, 0], 1.0), Ok(1.0));
/// assert_eq!(map.evaluate([0, 0], 3.0), Ok(0.0));
/// assert_eq!(map.deep_map()?.pixel(0, 0).len(), 2);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct MultilayerMap<T> {
    info: LayeredInfo,
    pixels: LayeredPixels<T>,
}

impl<T: Transmittance> MultilayerMap<T> {
    /// A map of these pixels.
    #[must_use]
    pub const fn new(info: LayeredInfo, pixels: LayeredPixels<T>) -> Self {
        Self { info, pixels }
    }

    /// The metadata of the map.
    #[must_use]
    pub const fn info(&self) -> &LayeredInfo {
        &self.info
    }

    /// The deep shadow map that the first runs are.
    ///
    /// # Errors
    ///
    /// None for a map that this crate has built or read.
    pub fn deep_map(&self) -> Result<DeepMap<T>> {
        let mut pixels = PixelListsBuilder::new(self.pixels.width(), self.pixels.height());
        for pixel in 0..self.pixels.pixel_count() {
            if let Some(run) = self.pixels.first_run(pixel) {
                run.function().vertices().for_each(|vertex| pixels.push(vertex));
            }
            pixels.finish_pixel()?;
        }
        Ok(DeepMap::new(self.info.map, pixels.finish()?))
    }

    /// The map's pixels.
    #[must_use]
    pub const fn pixels(&self) -> &LayeredPixels<T> {
        &self.pixels
    }
}

impl<T: Transmittance> VisibilityField for MultilayerMap<T> {
    type Value = T;
    type Error = std::convert::Infallible;

    fn size(&self) -> [u32; 2] {
        [self.pixels.width(), self.pixels.height()]
    }

    fn evaluate(&self, [x, y]: [u32; 2], depth: f32) -> std::result::Result<T, Self::Error> {
        let pixel = y as usize * self.pixels.width() as usize + x as usize;
        Ok(self.pixels.first_run(pixel).map_or(T::CLEAR, |run| run.function().at(depth)))
    }
}
