//! One sample of a deep pixel.

/// Point or volume sample of a deep pixel, as the file has it: neither checked nor
/// cleaned.
///
/// A point lies at its front depth; a volume reaches to its back and absorbs
/// evenly in between (*Interpreting OpenEXR Deep Pixels*).
///
/// ```
/// use deep_exr::DeepSample;
///
/// let wall = DeepSample { z: 8.0, z_back: 8.0, alpha: [1.0; 3] };
/// let smoke = DeepSample { z: 2.0, z_back: 4.0, alpha: [0.3, 0.3, 0.4] };
/// assert!(smoke.z_back > smoke.z && wall.z_back == wall.z);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeepSample {
    /// Depth of its front.
    pub z: f32,
    /// Depth of its back; the front's where the file has none.
    pub z_back: f32,
    /// Opacity for red, green and blue; 1 where the file has no alpha.
    pub alpha: [f32; 3],
}
