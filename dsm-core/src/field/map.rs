//! A deep shadow map in memory.

use super::pixel_lists::PixelLists;
use super::visibility_field::{BlockVisitor, VisibilityField};
use crate::camera::map_info::MapInfo;
use crate::transmittance::Transmittance;
use crate::visibility::function::VisibilityView;

/// A rectangular array of visibility functions (Lokovic & Veach 2000, §3.1).
///
/// ```
/// use dsm_core::{DeepMap, MapInfo, PixelListsBuilder, Vertex, VisibilityField};
///
/// let mut pixels = PixelListsBuilder::new(1, 1);
/// pixels.push(Vertex::new(2.0, 1.0));
/// pixels.push(Vertex::new(2.0, 0.25));
/// pixels.finish_pixel()?;
/// let map = DeepMap::new(MapInfo::default(), pixels.finish()?);
/// assert_eq!(map.evaluate([0, 0], 3.0), Ok(0.25));
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct DeepMap<T> {
    info: MapInfo,
    pixels: PixelLists<T>,
}

impl<T: Transmittance> DeepMap<T> {
    /// A map of these pixels.
    #[must_use]
    pub const fn new(info: MapInfo, pixels: PixelLists<T>) -> Self {
        Self { info, pixels }
    }

    /// The metadata of the map.
    #[must_use]
    pub const fn info(&self) -> &MapInfo {
        &self.info
    }

    /// The map's pixels.
    #[must_use]
    pub const fn pixels(&self) -> &PixelLists<T> {
        &self.pixels
    }

    /// The pixels alone, for callers that keep their columns.
    #[must_use]
    pub fn into_pixels(self) -> PixelLists<T> {
        self.pixels
    }

    /// The function of one pixel.
    ///
    /// # Panics
    ///
    /// If the pixel lies outside the map.
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32) -> VisibilityView<'_, T> {
        self.pixels.view().pixel(x, y)
    }
}

impl<T: Transmittance> VisibilityField for DeepMap<T> {
    type Value = T;
    type Error = std::convert::Infallible;
    const HAS_RUNS: bool = true;

    fn size(&self) -> [u32; 2] {
        let view = self.pixels.view();
        [view.width(), view.height()]
    }

    fn evaluate(&self, [x, y]: [u32; 2], depth: f32) -> Result<T, Self::Error> {
        Ok(self.pixel(x, y).at(depth))
    }

    #[inline(always)]
    fn evaluate_block(&self, visitor: &mut impl BlockVisitor<T>) -> Result<(), Self::Error> {
        let pixels = self.pixels.view();
        let [_, rows] = visitor.bounds();
        for row in rows {
            let columns = visitor.columns(row);
            assert!(columns.end <= pixels.width(), "the block is outside the map");
            let first = row as usize * pixels.width() as usize + columns.start as usize;
            visitor.take_run(columns, pixels, first);
        }
        Ok(())
    }
}
