//! Options of exports as deep OpenEXR.

use deep_exr::{Compression, Layout, SampleType};
use dsm_core::Tolerance;

/// Options of an export as deep OpenEXR: layout, types, compression, error.
///
/// ```
/// use dsm_io::ExportOptions;
/// use dsm_io::deep_exr::SampleType;
///
/// let options = ExportOptions { sample_type: SampleType::Half, ..ExportOptions::default() };
/// assert_eq!(options.error.epsilon(), ExportOptions::DEFAULT_ERROR);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExportOptions {
    /// Scan lines or tiles.
    pub layout: Layout,
    /// The type of opacities.
    pub sample_type: SampleType,
    /// The compression of chunks.
    pub compression: Compression,
    /// The bound of volumes' distance from the ramps they stand for, at least
    /// [`Self::LEAST_ERROR`]. Default 1e-5.
    pub error: Tolerance,
    /// Writes `deepImageState`, which says that samples are tidy,
    /// which they are. Not the default: several versions of the official
    /// Python client refuse files with that attribute.
    pub deep_image_state: bool,
}

impl ExportOptions {
    /// The minimum error bound: a few roundings of 32-bit opacities.
    pub const LEAST_ERROR: f32 = 1e-6;

    /// The default error bound.
    pub const DEFAULT_ERROR: f32 = 1e-5;
}

impl Default for ExportOptions {
    fn default() -> Self {
        Self {
            layout: Layout::default(),
            sample_type: SampleType::default(),
            compression: Compression::default(),
            error: Tolerance::new(Self::DEFAULT_ERROR).unwrap_or_default(),
            deep_image_state: false,
        }
    }
}
