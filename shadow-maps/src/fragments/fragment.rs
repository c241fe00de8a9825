//! One layer of a pixel, with the plane it lies in.

use dsm_core::Transmittance;

/// A piece of a surface within a pixel: a plane, an opacity, and the part of
/// the pixel that it covers.
///
/// Perspective keeps planes planes in (raster x, raster y, w = 1/depth): w and
/// its gradient say where each ray crosses it, exactly, and so a lit surface
/// does not shade itself. The coverage mask gives a map of n² pixels the
/// outlines of one of (8 n)².
///
/// ```
/// use shadow_maps::detail::Fragment;
///
/// // The right half of a pixel, at depth 4.
/// let coverage = 0xf0f0_f0f0_f0f0_f0f0;
/// let fragment = Fragment { w: 0.25, gradient: Some([0.0; 2]), opacity: 1.0_f32, coverage };
/// assert!(fragment.covers([0.75, 0.5]) && !fragment.covers([0.25, 0.5]));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fragment<T> {
    /// w of the plane at the pixel's centre, which need not be covered.
    pub w: f32,
    /// Growth of w per pixel to the right and downwards. None where the plane is
    /// unknown, as of hits without a normal: they are taken to face the camera.
    pub gradient: Option<[f32; 2]>,
    /// The share of light that it takes, in (0, 1].
    pub opacity: T,
    /// Bit 8 · row + column for each of 8 × 8 equal squares of the pixel, from
    /// the upper left: set where it is covered.
    pub coverage: u64,
}

impl<T: Transmittance> Fragment<T> {
    /// The coverage of a whole pixel.
    pub const WHOLE: u64 = u64::MAX;

    /// The gradient of its plane, or of the one that it is taken to lie in.
    #[must_use]
    pub const fn slope(&self) -> [f32; 2] {
        match self.gradient {
            Some(gradient) => gradient,
            None => [0.0; 2],
        }
    }

    /// True if it is taken to face the camera for want of a normal.
    #[must_use]
    pub const fn is_facing(&self) -> bool {
        self.gradient.is_none()
    }

    /// True if a point at `within` the pixel, in [0, 1)² from its upper left
    /// corner, is covered.
    #[must_use]
    pub fn covers(&self, within: [f64; 2]) -> bool {
        let [x, y] = within.map(|at| (at * 8.0) as u32);
        within.iter().all(|at| (0.0..1.0).contains(at)) && self.coverage >> (8 * y + x) & 1 == 1
    }

    /// The minimum and maximum w of its plane over the squares that it covers. O(squares).
    pub(super) fn covered(&self) -> [f64; 2] {
        let [right, down] = self.slope().map(f64::from);
        let squares = (0..64).filter(|square| self.coverage >> square & 1 == 1);
        let corners = squares.flat_map(|square| {
            let (x, y) = (square % 8, square / 8);
            [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)]
        });
        let w = corners.map(|(x, y)| {
            let [x, y] = [x, y].map(|at| f64::from(at) / 8.0 - 0.5);
            f64::from(self.w) + right * x + down * y
        });
        w.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], w| [low.min(w), high.max(w)])
    }

    /// The minimum and maximum w of its covered part: of the box around it,
    /// with room for the rounding of whoever meets it.
    #[must_use]
    pub fn range(&self) -> [f32; 2] {
        // All rows in one.
        let columns = (0..8).fold(0, |all, row| all | (self.coverage >> (8 * row)) as u8);
        let rows = (0..8).fold(0_u8, |all, row| {
            let covered = (self.coverage >> (8 * row)) as u8 != 0;
            all | u8::from(covered) << row
        });
        let span = |bits: u8, slope: f32| {
            let from = bits.trailing_zeros().min(8) as f32 / 8.0 - 0.5;
            let to = 0.5 - bits.leading_zeros().min(8) as f32 / 8.0;
            let [a, b] = [from * slope, to * slope];
            [a.min(b), a.max(b)]
        };
        let slope = self.slope();
        let [x_low, x_high] = span(columns, slope[0]);
        let [y_low, y_high] = span(rows, slope[1]);
        let [along_x, along_y] = slope.map(f32::abs);
        let room = 2e-6 * self.w.abs() + 1e-3 * (along_x + along_y);
        [self.w + x_low + y_low - room, self.w + x_high + y_high + room]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_hold_what_is_covered_and_little_more() {
        for coverage in [1, 1 << 63, 1 << 7, 0x0000_3c00_0000_0000, u64::MAX] {
            for gradient in [[0.0, 0.0], [0.01, -0.02], [-0.5, 0.25]] {
                let plane = Some(gradient);
                let fragment = Fragment { w: 0.25, gradient: plane, opacity: 0.5_f32, coverage };
                let [low, high] = fragment.range();
                let mut seen = [f32::INFINITY, f32::NEG_INFINITY];
                for at in (0..64).filter(|at| coverage >> at & 1 == 1) {
                    for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                        let x = (at % 8 + dx) as f32 / 8.0 - 0.5;
                        let y = (at / 8 + dy) as f32 / 8.0 - 0.5;
                        let w = 0.25 + gradient[0] * x + gradient[1] * y;
                        seen = [seen[0].min(w), seen[1].max(w)];
                    }
                }
                let slack = 0.002 * (gradient[0].abs() + gradient[1].abs()) + 1e-6;
                assert!(low <= seen[0] && seen[0] - low < slack, "{low} {seen:?}");
                assert!(high >= seen[1] && high - seen[1] < slack, "{high} {seen:?}");
            }
        }
    }

    #[test]
    fn only_what_has_no_normal_faces_the_camera() {
        let flat = Fragment { w: 1.0, gradient: Some([0.0; 2]), opacity: 1.0_f32, coverage: 1 };
        let strand = Fragment { gradient: None, ..flat };
        assert!(!flat.is_facing() && strand.is_facing());
        assert_eq!((flat.slope(), flat.range()), (strand.slope(), strand.range()));
        assert!(flat.covers([0.0, 0.124]) && !flat.covers([0.125, 0.0]));
        assert!(!flat.covers([-0.01, 0.0]) && !flat.covers([0.0, 1.0]));
    }
}
