//! One depth image.

use dsm_core::Error;
use dsm_core::detail::Result;
use dsm_trace::MinMaxPyramid;
use dsm_trace::detail::LightFrame;

use super::connected::Connected;

/// What one point of a light sees: the w = 1/depth of the nearest surface of each pixel, 0
/// where there is none.
///
/// Each pixel is a floor, parallel to the image; neighbours whose depths differ by no more
/// than the gap bias are connected by walls (Agrawala et al. 2000, §5.1).
///
/// Memory: 4 bytes a pixel, and 12 for the quadtrees.
#[derive(Clone, Debug)]
pub struct DepthView {
    frame: LightFrame,
    w: Vec<f32>,
    /// The most by which w differ over the lesser one, of pixels that are connected.
    gap: f64,
    /// The depths of pixels and of the walls around them.
    pub(super) ranges: MinMaxPyramid,
    pub(super) connected: Connected,
}

impl DepthView {
    /// The gap bias, in sides of a pixel at the nearer depth.
    pub const GAP: f64 = 4.0;

    /// The view of a camera in a point of the light, with this gap bias in sides of a
    /// pixel at the nearer of two depths. O(pixels · log side).
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] if there is not a w a pixel, one is negative or not finite, or
    /// the bias is negative or NaN; [`Error::TooLarge`] past
    /// [`MinMaxPyramid::MAX_PIXELS`].
    pub fn new(frame: LightFrame, w: Vec<f32>, gap: f64) -> Result<Self> {
        let size = frame.size();
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        if w.len() as u64 != pixels || !w.iter().all(|w| (0.0..f32::INFINITY).contains(w)) {
            let reason = "there must be one a pixel, finite and not negative";
            return Err(Error::Setting { setting: "1 / depths of a view", reason });
        }
        if gap.is_nan() || gap < 0.0 {
            let reason = "it must not be negative";
            return Err(Error::Setting { setting: "gap bias", reason });
        }
        // Depths differ by |1/a − 1/b|, a pixel's side is that of depth 1 over the greater.
        let gap = gap * frame.footprint(1.0);
        let of = |[x, y]: [u32; 2]| w[y as usize * size[0] as usize + x as usize];
        let joins = |a: [u32; 2], b: [u32; 2]| joins(gap, of(a), of(b));
        let ranges = MinMaxPyramid::new(size, |x, y| {
            let own = of([x, y]);
            let mut range = [own; 2];
            for near_y in y.saturating_sub(1)..(y + 2).min(size[1]) {
                for near_x in x.saturating_sub(1)..(x + 2).min(size[0]) {
                    let near = [near_x, near_y];
                    if joins([x, y], near) {
                        range = [range[0].min(of(near)), range[1].max(of(near))];
                    }
                }
            }
            Some(range)
        })?;
        let connected = Connected::new(size, joins);
        Ok(Self { frame, w, gap, ranges, connected })
    }

    /// The frame of the view.
    #[must_use]
    pub const fn frame(&self) -> &LightFrame {
        &self.frame
    }

    /// w of all pixels, row by row.
    #[must_use]
    pub fn w(&self) -> &[f32] {
        &self.w
    }

    /// w of a pixel.
    #[inline]
    pub(super) fn at(&self, [x, y]: [u32; 2]) -> f32 {
        self.w[y as usize * self.frame.size()[0] as usize + x as usize]
    }

    /// Whether a wall joins two pixels.
    #[inline]
    pub(super) fn is_wall(&self, a: [u32; 2], b: [u32; 2]) -> bool {
        joins(self.gap, self.at(a), self.at(b))
    }
}

/// Whether depths 1/`a` and 1/`b` differ by no more than the gap.
#[inline]
fn joins(gap: f64, a: f32, b: f32) -> bool {
    f64::from(a.max(b)) - f64::from(a.min(b)) <= gap * f64::from(a.min(b))
}
