//! Multilayer depth maps: the first hits of every pixel (Xie, Tabellion & Pearce
//! 2007, §4.2).

use dsm_core::detail::Result;
use dsm_core::{Error, SurfaceHit, Transmittance, VisibilityField};

use crate::multilayer_settings::LayeredInfo;

/// The layers of a rectangle of pixels, of a map or of a tile: each a depth and
/// an opacity, row by row and front to back.
///
/// ```
/// use dsm_core::SurfaceHit;
/// use mtsm::detail::DepthLayers;
///
/// let mut pixels = DepthLayers::clear(2, 1, 2);
/// for depth in [5.0, 3.0, 4.0] {
///     pixels.insert(SurfaceHit { depth, opacity: 1.0_f32 });
/// }
/// pixels.finish_pixel()?;
/// pixels.finish_pixel()?;
/// let depths: Vec<f32> = pixels.layers(0).map(|layer| layer.depth).collect();
/// assert_eq!(depths, [3.0, 4.0]);
/// assert_eq!(pixels.layers(1).len(), 0);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct DepthLayers<T> {
    width: u32,
    height: u32,
    max_layers: u32,
    /// Where each finished pixel's layers start, and the end.
    starts: Vec<u32>,
    depths: Vec<f32>,
    opacities: Vec<T>,
}

impl<T: Transmittance> DepthLayers<T> {
    /// `width` × `height` pixels to be filled one by one, each with up to
    /// `max_layers` layers.
    #[must_use]
    pub fn clear(width: u32, height: u32, max_layers: u32) -> Self {
        let (starts, depths, opacities) = (vec![0], Vec::new(), Vec::new());
        Self { width, height, max_layers, starts, depths, opacities }
    }

    /// The layers in these columns; `starts` has one entry a pixel and one for
    /// the end.
    ///
    /// # Errors
    ///
    /// [`Error::Pixel`] naming the first pixel whose columns don't fit together
    /// or break a rule: no more layers than the most, front to back, depths
    /// finite and ≥ 0, opacities in [0, 1]. O(layers).
    pub fn new(
        (width, height): (u32, u32),
        max_layers: u32,
        starts: Vec<u32>,
        depths: Vec<f32>,
        opacities: Vec<T>,
    ) -> Result<Self> {
        let layers = Self { width, height, max_layers, starts, depths, opacities };
        let refuse = |pixel, reason| Err(Error::Pixel { pixel, reason });
        let pixels = layers.pixel_count();
        let covers = layers.starts.len() == pixels + 1
            && layers.starts[0] == 0
            && layers.starts.is_sorted()
            && layers.starts[pixels] as usize == layers.depths.len()
            && layers.depths.len() == layers.opacities.len();
        if !covers {
            return refuse(pixels, "the pixel table does not cover the layers");
        }
        for pixel in 0..pixels {
            let all = layers.layers(pixel);
            if all.len() > max_layers as usize {
                return refuse(pixel, "it has more layers than the map allows");
            }
            let mut before = 0.0;
            for layer in all {
                if !(before..f32::INFINITY).contains(&layer.depth) {
                    return refuse(pixel, "depths must be finite, at least 0 and ascending");
                }
                let is_opacity = |channel| (0.0..=1.0).contains(&layer.opacity.channel(channel));
                if !(0..T::CHANNELS).all(is_opacity) {
                    return refuse(pixel, "opacities must lie in [0, 1]");
                }
                before = layer.depth;
            }
        }
        Ok(layers)
    }

    /// Inserts a hit into the current pixel, if it is closer than one of its
    /// layers or there is room behind them. Hits at one depth stay in order.
    pub fn insert(&mut self, hit: SurfaceHit<T>) {
        let first = self.starts.last().map_or(0, |&start| start as usize);
        let place = first + self.depths[first..].partition_point(|&depth| depth <= hit.depth);
        let most = first.saturating_add(self.max_layers as usize);
        if place < most {
            self.depths.insert(place, hit.depth);
            self.opacities.insert(place, hit.opacity);
            self.depths.truncate(most);
            self.opacities.truncate(most);
        }
    }

    /// Ends the current pixel and begins the next.
    ///
    /// # Errors
    ///
    /// [`Error::Pixel`] if there are more pixels than announced,
    /// [`Error::TooLarge`] past 2³² − 1 layers.
    pub fn finish_pixel(&mut self) -> Result<()> {
        let (pixel, reason) = (self.starts.len() - 1, "there is no such pixel");
        if pixel >= self.pixel_count() {
            return Err(Error::Pixel { pixel, reason });
        }
        let count = self.depths.len() as u64;
        let limit = u64::from(u32::MAX);
        let too_large = |_| Error::TooLarge { what: "layers", count, limit };
        self.starts.push(u32::try_from(count).map_err(too_large)?);
        Ok(())
    }

    /// Adds the next pixel, a copy of one of `pixels`.
    pub(crate) fn copy_pixel(&mut self, pixels: &Self, pixel: usize) -> Result<()> {
        pixels.layers(pixel).for_each(|layer| self.insert(layer));
        self.finish_pixel()
    }

    /// Width in pixels.
    #[must_use]
    pub const fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels.
    #[must_use]
    pub const fn height(&self) -> u32 {
        self.height
    }

    /// The most layers that a pixel may have.
    #[must_use]
    pub const fn max_layers(&self) -> u32 {
        self.max_layers
    }

    /// Number of pixels.
    #[must_use]
    pub const fn pixel_count(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Number of layers of all pixels.
    #[must_use]
    pub const fn layer_count(&self) -> usize {
        self.depths.len()
    }

    /// The layers of the pixel with row-major index `pixel`, front to back.
    ///
    /// # Panics
    ///
    /// If that pixel was not finished.
    pub fn layers(&self, pixel: usize) -> impl ExactSizeIterator<Item = SurfaceHit<T>> + '_ {
        let range = self.starts[pixel] as usize..self.starts[pixel + 1] as usize;
        let columns = self.depths[range.clone()].iter().zip(&self.opacities[range]);
        columns.map(|(&depth, &opacity)| SurfaceHit { depth, opacity })
    }

    /// The light that the layers of a pixel up to `depth` leave.
    ///
    /// # Panics
    ///
    /// If that pixel was not finished.
    #[must_use]
    pub fn transmittance(&self, pixel: usize, depth: f32) -> T {
        let passed = self.layers(pixel).take_while(|layer| layer.depth <= depth);
        passed.fold(T::CLEAR, |left, layer| {
            let past = layer.transmittance();
            T::from_channels(|channel| left.channel(channel) * past.channel(channel))
        })
    }

    /// The smallest and the largest depth of a pixel's layers.
    ///
    /// # Panics
    ///
    /// If that pixel was not finished.
    #[must_use]
    pub fn depth_range(&self, pixel: usize) -> Option<[f32; 2]> {
        match &self.depths[self.starts[pixel] as usize..self.starts[pixel + 1] as usize] {
            [first, .., last] | [first @ last] => Some([*first, *last]),
            [] => None,
        }
    }

    /// The index of each pixel's first layer, and the end.
    #[must_use]
    pub fn starts(&self) -> &[u32] {
        &self.starts
    }

    /// The depths of all layers.
    #[must_use]
    pub fn depths(&self) -> &[f32] {
        &self.depths
    }

    /// The opacities of all layers.
    #[must_use]
    pub fn opacities(&self) -> &[T] {
        &self.opacities
    }
}

/// A multilayer depth map (Xie, Tabellion & Pearce 2007, §4.2): the first layers
/// that one ray through each pixel meets.
///
/// As a [`VisibilityField`] it answers the product of what the layers up to a
/// depth let through.
#[derive(Clone, Debug, PartialEq)]
pub struct MultilayerDepthMap<T> {
    info: LayeredInfo,
    pixels: DepthLayers<T>,
}

impl<T: Transmittance> MultilayerDepthMap<T> {
    /// A map of these pixels, all of them finished.
    #[must_use]
    pub const fn new(info: LayeredInfo, pixels: DepthLayers<T>) -> Self {
        Self { info, pixels }
    }

    /// The metadata of the map.
    #[must_use]
    pub const fn info(&self) -> &LayeredInfo {
        &self.info
    }

    /// The map's pixels.
    #[must_use]
    pub const fn pixels(&self) -> &DepthLayers<T> {
        &self.pixels
    }
}

impl<T: Transmittance> VisibilityField for MultilayerDepthMap<T> {
    type Value = T;
    type Error = std::convert::Infallible;

    fn size(&self) -> [u32; 2] {
        [self.pixels.width(), self.pixels.height()]
    }

    fn evaluate(&self, [x, y]: [u32; 2], depth: f32) -> std::result::Result<T, Self::Error> {
        let pixel = y as usize * self.pixels.width() as usize + x as usize;
        Ok(self.pixels.transmittance(pixel, depth))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn insertion_keeps_the_nearest() {
        let depths = [4.0, 1.0, 3.0, 1.0, 2.0, 9.0];
        for most in 1..8_u32 {
            let mut pixels = DepthLayers::<f32>::clear(1, 1, most);
            for (index, depth) in (0_u8..).zip(depths) {
                pixels.insert(SurfaceHit { depth, opacity: f32::from(index) / 8.0 });
            }
            pixels.finish_pixel().unwrap();
            let mut expected: Vec<_> = (0_u8..)
                .zip(depths)
                .map(|(index, depth)| (depth, f32::from(index) / 8.0))
                .collect();
            expected.sort_by(|a, b| a.0.total_cmp(&b.0));
            expected.truncate(most as usize);
            let found: Vec<_> = pixels.layers(0).map(|hit| (hit.depth, hit.opacity)).collect();
            assert_eq!(found, expected);
            assert!(pixels.finish_pixel().is_err());
        }
    }

    #[test]
    fn columns_that_break_a_rule_are_refused() {
        let layers = |starts: &[u32], depths: &[f32], opacities: &[f32]| {
            DepthLayers::new((2, 1), 2, starts.to_vec(), depths.to_vec(), opacities.to_vec())
        };
        assert!(layers(&[0, 0, 2], &[1.0, 1.0], &[0.0, 1.0]).is_ok());
        for (starts, depths, opacities) in [
            (&[0, 2][..], &[1.0, 1.0][..], &[0.0, 1.0][..]),
            (&[0, 3, 2], &[1.0, 1.0], &[0.0, 1.0]),
            (&[0, 1, 1], &[1.0, 1.0], &[0.0, 1.0]),
            (&[0, 0, 2], &[1.0, 1.0], &[0.0]),
            (&[0, 0, 2], &[2.0, 1.0], &[0.0, 1.0]),
            (&[0, 0, 2], &[1.0, f32::NAN], &[0.0, 1.0]),
            (&[0, 0, 2], &[-1.0, 1.0], &[0.0, 1.0]),
            (&[0, 0, 2], &[1.0, 1.0], &[0.0, 1.5]),
            (&[0, 0, 2], &[1.0, 1.0], &[0.0, f32::NAN]),
            (&[0, 0, 3], &[1.0, 1.0, 1.0], &[0.0, 1.0, 1.0]),
        ] {
            assert!(layers(starts, depths, opacities).is_err(), "{starts:?} {depths:?}");
        }
    }

    #[test]
    fn as_a_field_it_multiplies() {
        let pixels = DepthLayers::new((1, 1), 3, vec![0, 2], vec![1.0, 2.0], vec![0.5_f32, 0.75]);
        let map = MultilayerDepthMap::new(LayeredInfo::default(), pixels.unwrap());
        let light = [0.5, 1.0, 1.5, 2.0].map(|z| map.evaluate([0, 0], z).unwrap());
        assert_eq!(light, [1.0, 0.5, 0.5, 0.125]);
    }
}
