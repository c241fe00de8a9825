//! A place in a map.

/// The pixel, depth and channel at which two maps differ the most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorstPixel {
    /// Index of the level; of an image 0.
    pub level: u32,
    /// Column.
    pub x: u32,
    /// Row.
    pub y: u32,
    /// Depth.
    pub z: f32,
    /// Channel: 0, or 0 to 2 for coloured maps.
    pub channel: usize,
    /// The absolute difference there.
    pub difference: f64,
}
