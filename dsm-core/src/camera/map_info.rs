//! Metadata of a map.

use serde::{Deserialize, Serialize};

use super::pixel_window::PixelWindow;
use super::shadow_camera::{DepthKind, ShadowCamera};
use crate::filter::Filter;
use crate::light::LightExtent;
use crate::tolerance::Tolerance;

/// The metadata of a map: all that a query needs besides its pixels.
///
/// ```
/// use dsm_core::{MapInfo, Tolerance};
///
/// let info = MapInfo { tolerance: Tolerance::new(0.01)?, ..MapInfo::default() };
/// assert_eq!(info.camera, None);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
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
    /// The light that the map looks from, if known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub light: Option<LightExtent>,
}
