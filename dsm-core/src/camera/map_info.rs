//! Metadata of a map.

use serde::{Deserialize, Serialize};

use super::pixel_window::PixelWindow;
use super::shadow_camera::{DepthKind, ShadowCamera};
use crate::compress::compressor::{Compression, read_stated};
use crate::filter::Filter;
use crate::light_extent::LightExtent;
use crate::tolerance::Tolerance;

/// The metadata of a map: all that a query needs besides its pixels.
///
/// ```
/// use dsm_core::{MapInfo, Tolerance};
///
/// let info = MapInfo::new().with_tolerance(Tolerance::new(0.01)?).with_samples(16);
/// assert_eq!((info.camera, info.samples), (None, Some(16)));
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct MapInfo {
    /// The shadow camera, if known.
    pub camera: Option<ShadowCamera>,
    /// The measure of its depths.
    pub depth_kind: DepthKind,
    /// The bound that every pixel keeps.
    pub tolerance: Tolerance,
    /// Samples a pixel, if the map was sampled.
    pub samples: Option<u32>,
    /// The pixel filter, if the map was sampled.
    pub filter: Option<Filter>,
    /// The pixels of the image plane that the map covers, if it came from an
    /// image: its pixel (0, 0) is `min`.
    pub data_window: Option<PixelWindow>,
    /// The pixels that NDC [0, 1]² covers, if the map came from an image.
    pub display_window: Option<PixelWindow>,
    /// How its functions were compressed, if known.
    #[serde(default, deserialize_with = "read_stated")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub compression: Option<Compression>,
    /// The light that the map looks from, if known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub light: Option<LightExtent>,
}

impl MapInfo {
    /// Nothing is known, and the map is exact.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets the shadow camera.
    #[must_use]
    pub fn with_camera(self, camera: ShadowCamera) -> Self {
        Self { camera: Some(camera), ..self }
    }

    /// Sets the bound that every pixel keeps.
    #[must_use]
    pub fn with_tolerance(self, tolerance: Tolerance) -> Self {
        Self { tolerance, ..self }
    }

    /// Sets the samples a pixel.
    #[must_use]
    pub fn with_samples(self, samples: u32) -> Self {
        Self { samples: Some(samples), ..self }
    }

    /// Sets the pixel filter.
    #[must_use]
    pub fn with_filter(self, filter: Filter) -> Self {
        Self { filter: Some(filter), ..self }
    }

    /// Sets the pixels of the image plane that the map covers.
    #[must_use]
    pub fn with_data_window(self, window: PixelWindow) -> Self {
        Self { data_window: Some(window), ..self }
    }

    /// Sets the pixels that NDC [0, 1]² covers.
    #[must_use]
    pub fn with_display_window(self, window: PixelWindow) -> Self {
        Self { display_window: Some(window), ..self }
    }

    /// Sets how its functions were compressed.
    #[must_use]
    pub fn with_compression(self, compression: Compression) -> Self {
        Self { compression: Some(compression), ..self }
    }

    /// Sets the light that the map looks from.
    #[must_use]
    pub fn with_light(self, light: LightExtent) -> Self {
        Self { light: Some(light), ..self }
    }
}
