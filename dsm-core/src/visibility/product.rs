//! The product of visibility functions: the visibility through several occluders,
//! each with a map of its own.

use std::marker::PhantomData;

use super::polyline::Polyline;
use super::vertex::SumVertex;
use super::vertex_writer::VertexWriter;
use super::walk::Walk;
use crate::tolerance::Tolerance;
use crate::transmittance::Transmittance;

/// A multiplier of visibility functions of one pixel.
///
/// That is the light past all of them where what they block has nothing to do
/// with each other, as with media, or where each covers the whole pixel. Two
/// opaque halves of a pixel multiply to ¼; the truth is ½ if they are the same
/// half and 0 if they are not.
///
/// Between neighbouring vertices the product of n straight lines is a
/// polynomial of degree n, falling and convex; chords stand for it.
///
/// ```
/// use dsm_core::detail::VisibilityProduct;
/// use dsm_core::{Vertex, VisibilityFunction};
///
/// let step = |z, to| VisibilityFunction::new([(z, 1.0), (z, to)].map(|(z, v)| Vertex::new(z, v)));
/// let mut product = VisibilityProduct::<f32>::default();
/// product.multiply(&[step(1.0, 0.5)?, step(2.0, 0.25)?], 0.0);
/// let vertices: Vec<_> = product.vertices().iter().map(|v| (v.z, v.value[0])).collect();
/// assert_eq!(vertices, [(1.0, 1.0), (1.0, 0.5), (2.0, 0.5), (2.0, 0.125)]);
/// assert_eq!(product.chord_error(), 0.0);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct VisibilityProduct<T: Transmittance> {
    vertices: Vec<SumVertex<T>>,
    chord_error: f64,
}

impl<T: Transmittance> Default for VisibilityProduct<T> {
    fn default() -> Self {
        Self { vertices: Vec::new(), chord_error: 0.0 }
    }
}

impl<T: Transmittance> VisibilityProduct<T> {
    /// Computes the product of `functions`, with chords that are off by at
    /// most `chord_error`, or [`Tolerance::CHORD_FLOOR`] if that is less.
    ///
    /// Steps multiply exactly, but for the rounding of `f64`s, and so do the
    /// two ends; no chord lies below the product. Only one function that
    /// isn't clear passes unchanged. O(m n) for n functions with m vertices
    /// together, and chords of at most about 0.35 n / √error more vertices
    /// a channel.
    pub fn multiply<P>(&mut self, functions: &[P], chord_error: f64)
    where
        P: Polyline<Sum = T::Sum>,
    {
        self.vertices.clear();
        self.chord_error = 0.0;
        let mut blocking = functions.iter().filter(|function| function.vertex_count() > 0);
        match (blocking.next(), blocking.next()) {
            (None, _) => {}
            (Some(alone), None) => {
                let vertices = (0..alone.vertex_count()).map(|index| alone.sum_vertex(index));
                self.vertices.extend(vertices);
            }
            (Some(first), Some(second)) => {
                let factors = [first, second].into_iter().chain(blocking);
                let walks = factors.map(|factor| Walk::new(factor, T::CLEAR.to_sum())).collect();
                let mut factors =
                    Factors::<T, P> { walks, lines: Vec::new(), channels: PhantomData };
                let vertices = &mut self.vertices;
                let writer = VertexWriter::new(|vertex| vertices.push(vertex));
                self.chord_error = factors.run(writer, chord_error.max(Tolerance::CHORD_FLOOR));
            }
        }
    }

    /// The product's vertices, front to back; they satisfy the invariant of
    /// [`VisibilityView`](super::function::VisibilityView).
    #[must_use]
    pub fn vertices(&self) -> &[SumVertex<T>] {
        &self.vertices
    }

    /// The largest distance of the chords above the product; 0 if there are none.
    #[must_use]
    pub const fn chord_error(&self) -> f64 {
        self.chord_error
    }
}

/// A factor of one channel over a stretch on which it is straight: its values
/// at both ends.
type Line = [f64; 2];

/// The factor's value at this share of the stretch.
fn at([from, to]: Line, share: f64) -> f64 {
    (from - to).mul_add(-share, from)
}

struct Factors<'a, T: Transmittance, P: Polyline<Sum = T::Sum>> {
    walks: Vec<Walk<'a, P>>,
    /// The lines of one stretch, all channels of one factor after the other.
    lines: Vec<Line>,
    channels: PhantomData<T>,
}

impl<T: Transmittance, P: Polyline<Sum = T::Sum>> Factors<'_, T, P> {
    /// Draws the product; how far its chords are off.
    fn run<F: FnMut(SumVertex<T>)>(
        &mut self,
        mut writer: VertexWriter<T, F>,
        chord_error: f64,
    ) -> f64 {
        let mut spent = 0.0_f64;
        let mut near: Option<f32> = None;
        loop {
            let far = self.walks.iter().map(Walk::next_depth).fold(f32::INFINITY, f32::min);
            if far == f32::INFINITY {
                break;
            }
            if let Some(near) = near {
                spent = spent.max(self.draw_stretch(near, far, chord_error, &mut writer));
            }
            let mut sides = [T::CLEAR.to_sum(); 2];
            for [before, at] in self.walks.iter_mut().map(|walk| walk.advance(far)) {
                for (product, factor) in sides.iter_mut().zip([before, at]) {
                    let channels = product.as_mut().iter_mut().zip(factor.as_ref());
                    channels.for_each(|(product, factor)| *product *= factor);
                }
            }
            sides.into_iter().for_each(|value| writer.line_to(far, value));
            if writer.value() == T::BLOCKED.to_sum() {
                break;
            }
            near = Some(far);
        }
        spent
    }

    /// Draws the inside of the stretch from `near` to `far`, without its ends;
    /// how far its chords are off.
    fn draw_stretch<F: FnMut(SumVertex<T>)>(
        &mut self,
        near: f32,
        far: f32,
        chord_error: f64,
        writer: &mut VertexWriter<T, F>,
    ) -> f64 {
        self.find_lines(near, far);
        // No chord for what no two factors bend.
        if self.bend(0.0) == 0.0 {
            return 0.0;
        }
        let (start, length) = (f64::from(near), f64::from(far) - f64::from(near));
        let (mut spent, mut z, mut share) = (0.0_f64, near, 0.0_f64);
        while z < far {
            // A chord over a share s is off by at most |P″| s² / 8, and P″
            // falls on the way: what is enough here is enough from here on.
            let bend = self.bend(share);
            let left = 1.0 - share;
            let pieces = (left * (bend / (8.0 * chord_error)).sqrt()).ceil().max(1.0);
            let mut next = far;
            if pieces > 1.0 {
                let aim = start + length * (share + left / pieces);
                let below =
                    if f64::from(aim as f32) > aim { (aim as f32).next_down() } else { aim as f32 };
                // Between neighbouring depths there is nothing to be off.
                next = below.max(z.next_up()).min(far);
            }
            let next_share = (f64::from(next) - start) / length;
            if next > z.next_up() {
                spent = spent.max(bend * (next_share - share).powi(2) / 8.0);
            }
            if next < far {
                writer.line_to(next, self.value(next_share));
            }
            (z, share) = (next, next_share);
        }
        spent
    }

    /// Notes the factors' lines between two depths that have none of their
    /// vertices between them.
    fn find_lines(&mut self, near: f32, far: f32) {
        self.lines.clear();
        for [from, to] in self.walks.iter_mut().map(|walk| walk.line(near, far)) {
            let channels = from.as_ref().iter().zip(to.as_ref());
            self.lines.extend(channels.map(|(&from, &to)| [from, to]));
        }
    }

    /// The product at this share of the stretch.
    fn value(&self, share: f64) -> T::Sum {
        T::sum_from_channels(|channel| {
            let value: f64 = self.channel(channel).map(|line| at(line, share)).product();
            // Rounding must not pass the end.
            value.max(self.channel(channel).map(|[_, to]| to).product())
        })
    }

    /// P″ at this share of the stretch, of the channel where it is largest.
    fn bend(&self, share: f64) -> f64 {
        let bend = |channel| {
            let derivatives = |[value, slope, bend]: [f64; 3], line: Line| {
                let (factor, rise) = (at(line, share), line[1] - line[0]);
                [value * factor, slope * factor + value * rise, bend * factor + 2.0 * slope * rise]
            };
            self.channel(channel).fold([1.0, 0.0, 0.0], derivatives)[2]
        };
        (0..T::CHANNELS).map(bend).fold(0.0, f64::max)
    }

    fn channel(&self, channel: usize) -> impl Iterator<Item = Line> {
        self.lines.iter().skip(channel).step_by(T::CHANNELS).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::visibility::function::VisibilityFunction;
    use crate::visibility::vertex::Vertex;

    fn function(vertices: &[(f32, f32)]) -> VisibilityFunction<f32> {
        VisibilityFunction::new(vertices.iter().map(|&(z, value)| Vertex::new(z, value))).unwrap()
    }

    fn product(functions: &[VisibilityFunction<f32>], error: f64) -> (Vec<(f32, f64)>, f64) {
        let mut product = VisibilityProduct::<f32>::default();
        product.multiply(functions, error);
        let vertices = product.vertices().iter().map(|vertex| (vertex.z, vertex.value[0]));
        (vertices.collect(), product.chord_error())
    }

    #[test]
    fn a_step_scales_what_lies_behind_it() {
        let ramp = function(&[(1.0, 1.0), (3.0, 0.5)]);
        let step = function(&[(2.0, 1.0), (2.0, 0.5)]);
        let expected = [(1.0, 1.0), (2.0, 0.75), (2.0, 0.375), (3.0, 0.25)];
        assert_eq!(product(&[ramp, step], 0.0), (expected.to_vec(), 0.0));
    }

    #[test]
    fn two_ramps_are_a_parabola() {
        let ramp = function(&[(0.0, 1.0), (8.0, 0.0)]);
        // P″ = 2 over the stretch: a chord over a quarter is off by 1/64.
        let (vertices, error) = product(&[ramp.clone(), ramp], 1.0 / 64.0);
        let expected = [0.0_f32, 2.0, 4.0, 6.0, 8.0].map(|z| {
            let left = 1.0 - f64::from(z) / 8.0;
            (z, left * left)
        });
        assert_eq!((vertices, error), (expected.to_vec(), 1.0 / 64.0));
    }

    #[test]
    fn nothing_is_behind_a_blocker() {
        let wall = function(&[(1.0, 1.0), (1.0, 0.0)]);
        let ramp = function(&[(0.0, 1.0), (8.0, 0.5)]);
        let (vertices, error) = product(&[wall, ramp], 0.0);
        assert_eq!((vertices, error), (vec![(0.0, 1.0), (1.0, 0.9375), (1.0, 0.0)], 0.0));
    }

    #[test]
    fn clear_functions_change_nothing() {
        let odd = [(1.0, 1.0), (1.0, 1.0), (2.0, 0.5), (3.0, 0.5), (3.0, 0.5)];
        let functions = [VisibilityFunction::clear(), function(&odd), VisibilityFunction::clear()];
        assert_eq!(product(&functions, 0.0).0, odd.map(|(z, value)| (z, f64::from(value))));
        assert_eq!(product(&functions[..1], 0.0).0, []);
        assert_eq!(product(&[], 0.0).0, []);
    }
}
