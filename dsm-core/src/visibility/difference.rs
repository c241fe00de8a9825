//! The difference of two visibility functions.

use super::polyline::Polyline;
use super::walk::{Walk, zip};

/// The difference of two functions of one pixel, in the L∞ norm that bounds
/// are stated in (Lokovic & Veach 2000, §3.3) and on average.
///
/// Exact up to `f64` rounding: between neighbouring vertices of the two both
/// are linear, so the largest difference stands at one side of a vertex.
///
/// ```
/// use dsm_core::detail::VisibilityDifference;
/// use dsm_core::{Vertex, VisibilityFunction};
///
/// let step = [(2.0, 1.0), (2.0, 0.5)].map(|(z, value)| Vertex::new(z, value));
/// let ramp = [(2.0, 1.0), (4.0, 0.5)].map(|(z, value)| Vertex::new(z, value));
/// let (step, ramp) = (VisibilityFunction::new(step)?, VisibilityFunction::new(ramp)?);
/// let difference = VisibilityDifference::between(&step, &ramp);
/// assert_eq!((difference.max(), difference.depth()), (0.5, 2.0));
/// assert_eq!(difference.mean(), 0.25);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VisibilityDifference {
    max: f64,
    depth: f32,
    channel: usize,
    mean: f64,
}

impl VisibilityDifference {
    /// The difference of `a` and `b`. O(n + m), allocates nothing.
    #[must_use]
    pub fn between<A, B>(a: &A, b: &B) -> Self
    where
        A: Polyline + ?Sized,
        B: Polyline<Sum = A::Sum> + ?Sized,
    {
        let first = |function: &A| (function.vertex_count() > 0).then(|| function.sum_vertex(0));
        let Some(any) = first(a).or((b.vertex_count() > 0).then(|| b.sum_vertex(0))) else {
            return Self::default();
        };
        let clear = zip(any.value, any.value, |_, _| 1.0);
        let (mut a, mut b) = (Walk::new(a, clear), Walk::new(b, clear));
        let mut difference = Self::default();
        let start = smaller(a.next_depth(), b.next_depth());
        let mut sides = 0.0;
        // The last knot: its depth and the signed differences behind it.
        let mut last = f64::from(start);
        let mut behind = zip(clear, clear, |_, _| 0.0);
        let mut integral = 0.0;
        loop {
            let z = smaller(a.next_depth(), b.next_depth());
            if z == f32::INFINITY {
                break;
            }
            let ([a_before, a_at], [b_before, b_at]) = (a.advance(z), b.advance(z));
            let before = zip(a_before, b_before, |a, b| a - b);
            let at = zip(a_at, b_at, |a, b| a - b);
            let length = f64::from(z) - last;
            last = f64::from(z);
            let channels = before.as_ref().iter().zip(at.as_ref()).zip(behind.as_ref());
            for (channel, ((&before, &at), &behind)) in channels.enumerate() {
                integral += length * mean_magnitude(behind, before);
                if before.abs() > difference.max || at.abs() > difference.max {
                    difference.max = before.abs().max(at.abs());
                    difference.depth = z;
                    difference.channel = channel;
                }
                if z == start {
                    sides += before.abs() + at.abs();
                }
            }
            behind = at;
        }
        let length = last - f64::from(start);
        let sum = if length > 0.0 { integral / length } else { sides / 2.0 };
        difference.mean = sum / clear.as_ref().len() as f64;
        difference
    }

    /// This difference with another maximum.
    pub(crate) const fn with_max(self, max: f64, depth: f32, channel: usize) -> Self {
        Self { max, depth, channel, ..self }
    }

    /// The largest difference at any depth, in any channel.
    #[must_use]
    pub const fn max(&self) -> f64 {
        self.max
    }

    /// The first depth of the largest difference; 0 if there is none.
    #[must_use]
    pub const fn depth(&self) -> f32 {
        self.depth
    }

    /// The channel of the largest difference.
    #[must_use]
    pub const fn channel(&self) -> usize {
        self.channel
    }

    /// ∫ |a − b| dz from the first vertex of either to the last, over its
    /// length, averaged over the channels. Where all vertices share one depth:
    /// the mean of the differences at its two sides.
    #[must_use]
    pub const fn mean(&self) -> f64 {
        self.mean
    }
}

/// The mean of |f| where f is linear between `from` and `to`.
#[inline(always)]
fn mean_magnitude(from: f64, to: f64) -> f64 {
    let (start, end) = (from.abs(), to.abs());
    // Two triangles that meet where f crosses 0. No branch: which way f runs
    // cannot be foreseen.
    let crossing = 0.5 * (start * start + end * end) / (start + end);
    std::hint::select_unpredictable(from * to < 0.0, crossing, 0.5 * (start + end))
}

/// The smaller of two depths, neither of them NaN.
#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The differences of many pixels: a tile, a level or a map.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DifferenceSummary {
    worst: Option<(usize, VisibilityDifference)>,
    means: f64,
    pixels: usize,
}

impl DifferenceSummary {
    /// Counts one pixel in.
    pub fn add(&mut self, pixel: usize, difference: VisibilityDifference) {
        self.means += difference.mean;
        self.pixels += 1;
        self.keep_worst(pixel, difference);
    }

    /// Counts in so many pixels without a difference. O(1).
    pub const fn add_equal(&mut self, pixels: usize) {
        self.pixels += pixels;
    }

    /// Counts in the pixels of another summary.
    pub fn merge(&mut self, other: &Self) {
        self.means += other.means;
        self.pixels += other.pixels;
        if let Some((pixel, difference)) = other.worst {
            self.keep_worst(pixel, difference);
        }
    }

    /// Keeps the larger difference; of equals the first pixel, whatever order they
    /// come in.
    fn keep_worst(&mut self, pixel: usize, difference: VisibilityDifference) {
        let replaces = self.worst.is_none_or(|(worst, kept)| {
            difference.max > kept.max || (difference.max == kept.max && pixel < worst)
        });
        if replaces {
            self.worst = Some((pixel, difference));
        }
    }

    /// The largest difference of any pixel; 0 without pixels.
    #[must_use]
    pub fn max(&self) -> f64 {
        self.worst.map_or(0.0, |(_, difference)| difference.max)
    }

    /// The pixel of the largest difference, the first if several have it.
    #[must_use]
    pub const fn worst(&self) -> Option<(usize, VisibilityDifference)> {
        self.worst
    }

    /// The mean of the pixels' means; 0 without pixels.
    #[must_use]
    pub fn mean(&self) -> f64 {
        if self.pixels == 0 { 0.0 } else { self.means / self.pixels as f64 }
    }

    /// Number of pixels counted in.
    #[must_use]
    pub const fn pixels(&self) -> usize {
        self.pixels
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transmittance::{Rgb, Transmittance};
    use crate::visibility::function::VisibilityFunction;
    use crate::visibility::vertex::Vertex;

    fn step(z: f32, to: Rgb) -> VisibilityFunction<Rgb> {
        let vertices = [Vertex::new(z, Rgb::new(1.0, 1.0, 1.0)), Vertex::new(z, to)];
        VisibilityFunction::new(vertices).unwrap()
    }

    #[test]
    fn names_the_first_depth_and_the_channel() {
        let near = step(1.0, Rgb::new(0.75, 0.5, 1.0));
        let far = step(3.0, Rgb::new(0.75, 0.25, 1.0));
        let difference = VisibilityDifference::between(&near, &far);
        assert_eq!(
            (difference.max(), difference.depth(), difference.channel()),
            (0.5, 1.0, 1),
            "{difference:?}"
        );
        assert_eq!(difference.mean(), (0.25 + 0.5 + 0.0) / 3.0);
    }

    #[test]
    fn nothing_differs_from_a_clear_function_by_what_it_blocks() {
        let clear = VisibilityFunction::<Rgb>::clear();
        assert_eq!(VisibilityDifference::between(&clear, &clear), VisibilityDifference::default());
        let difference = VisibilityDifference::between(&step(2.0, Rgb::splat(0.25)), &clear);
        assert_eq!((difference.max(), difference.mean()), (0.75, 0.375));
    }

    #[test]
    fn a_summary_keeps_the_first_of_the_worst_in_any_order() {
        let clear = VisibilityFunction::<Rgb>::clear();
        let [slight, bad] =
            [0.75, 0.5].map(|to| VisibilityDifference::between(&step(2.0, Rgb::splat(to)), &clear));
        let pixels = [(0, slight), (1, bad), (2, slight), (3, bad)];
        let mut forwards = DifferenceSummary::default();
        pixels.iter().for_each(|&(pixel, difference)| forwards.add(pixel, difference));
        let mut backwards = DifferenceSummary::default();
        pixels.iter().rev().for_each(|&(pixel, difference)| backwards.add(pixel, difference));
        let mut halves = [DifferenceSummary::default(); 2];
        for (pixel, difference) in pixels {
            halves[pixel / 2].add(pixel, difference);
        }
        let [mut merged, rest] = halves;
        merged.merge(&rest);
        for summary in [forwards, backwards, merged] {
            assert_eq!(summary.worst(), Some((1, bad)));
            assert_eq!((summary.max(), summary.pixels()), (0.5, 4));
            assert_eq!(summary.mean(), (0.125 + 0.25) / 2.0);
        }
        assert_eq!(
            (DifferenceSummary::default().max(), DifferenceSummary::default().mean()),
            (0.0, 0.0)
        );
    }
}
