//! Rectangles of pixels.

use serde::{Deserialize, Serialize};

/// A rectangle of pixels, both corners inclusive, x right and y down.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PixelWindow {
    /// The upper left pixel.
    pub min: [i32; 2],
    /// The lower right pixel.
    pub max: [i32; 2],
}

impl PixelWindow {
    /// Width and height in pixels; 0 where `max` lies before `min`.
    #[must_use]
    pub fn size(self) -> [u64; 2] {
        [0, 1].map(|axis| {
            u64::try_from(i64::from(self.max[axis]) - i64::from(self.min[axis]) + 1).unwrap_or(0)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_count_both_corners() {
        assert_eq!(PixelWindow { min: [-3, 2], max: [4, 2] }.size(), [8, 1]);
        assert_eq!(PixelWindow { min: [0, 0], max: [-1, 0] }.size(), [0, 1]);
    }
}
