//! How maps become deep OpenEXR images.

use deep_exr::{Compression, Layout, SampleType};
use dsm_core::Tolerance;

/// How a map is written as a deep OpenEXR.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExportOptions {
    /// Scan lines or tiles.
    pub layout: Layout,
    /// How opacities are stored.
    pub sample_type: SampleType,
    /// How chunks are compressed.
    pub compression: Compression,
    /// How far volumes may be off the ramps that they stand for, at least
    /// [`Self::LEAST_ERROR`]. Default 1e-5.
    pub error: Tolerance,
    /// Whether the file says in `deepImageState` that its samples are tidy,
    /// which they are. Not the default: several versions of the official
    /// Python client refuse files with that attribute.
    pub deep_image_state: bool,
}

impl ExportOptions {
    /// The smallest error that can be asked for: a few roundings of 32-bit
    /// opacities.
    pub const LEAST_ERROR: f32 = 1e-6;

    /// The error when none is asked for.
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
