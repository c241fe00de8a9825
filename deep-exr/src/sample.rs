//! One sample of a deep pixel.

/// One sample, as the file has it: not checked, not cleaned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeepSample {
    /// Depth of its front.
    pub z: f32,
    /// Depth of its back; the front's where the file has none.
    pub z_back: f32,
    /// Opacity for red, green and blue; 1 where the file has no alpha.
    pub alpha: [f32; 3],
}
