//! The difference of visibility functions whose depths may have been moved.

use super::difference::VisibilityDifference;
use super::polyline::Polyline;
use super::walk::zip;

impl VisibilityDifference {
    /// The difference of `stored` from `exact` where depths may have been moved
    /// away from the light by up to `depth_error` scene units, as codec `quantized`
    /// does.
    ///
    /// [`Self::max`] is the smallest ε, at least 0, for which V(z) − ε ≤ V′(z) ≤
    /// V₋(z − δ) + ε at every depth z, V₋ being V's limit from the light's side.
    /// [`Self::mean`] is that of [`Self::between`], which is all of this for a
    /// depth error of 0. O(n + m), allocates nothing.
    ///
    /// ```
    /// use dsm_core::detail::VisibilityDifference;
    /// use dsm_core::{Vertex, VisibilityFunction};
    ///
    /// let step = |z| VisibilityFunction::new([(z, 1.0), (z, 0.5)].map(|(z, v)| Vertex::new(z, v)));
    /// let (exact, moved) = (step(2.0)?, step(2.25)?);
    /// let difference = |error| VisibilityDifference::with_moved_depths(&moved, &exact, error);
    /// assert_eq!([0.0, 0.125, 0.25].map(|error| difference(error).max()), [0.5, 0.5, 0.0]);
    /// // Nothing may be moved towards the light.
    /// let nearer = VisibilityDifference::with_moved_depths(&exact, &moved, 0.25);
    /// assert_eq!(nearer.max(), 0.5);
    /// # Ok::<(), dsm_core::Error>(())
    /// ```
    #[must_use]
    pub fn with_moved_depths<A, B>(stored: &A, exact: &B, depth_error: f32) -> Self
    where
        A: Polyline + ?Sized,
        B: Polyline<Sum = A::Sum> + ?Sized,
    {
        let between = Self::between(stored, exact);
        if depth_error <= 0.0 || between.max() == 0.0 {
            return between;
        }
        let too_dark = max_above(exact, 0.0, stored);
        let too_light = max_above(stored, depth_error.into(), exact);
        let worst = if too_light.0 > too_dark.0 { too_light } else { too_dark };
        let (max, depth, channel) = worst;
        between.with_max(max, depth, channel)
    }
}

/// The largest fall of a function over a `distance` in depth, of any channel: how far
/// a function is off at one depth, beside its ε, whose depths may have been moved away
/// from the light by that much ([`VisibilityDifference::with_moved_depths`]). For from
/// V′(z + δ) ≤ V(z) + ε follows V′(z) − V(z) ≤ V′(z) − V′(z + δ) + ε. 0 for a distance
/// of 0. O(vertices), allocates nothing.
///
/// ```
/// use dsm_core::{Vertex, VisibilityFunction};
/// use dsm_core::detail::largest_fall;
///
/// let ramp = VisibilityFunction::new([(2.0, 1.0), (4.0, 0.0)].map(|(z, v)| Vertex::new(z, v)))?;
/// assert_eq!([0.0, 0.5, 9.0].map(|distance| largest_fall(&ramp, distance)), [0.0, 0.25, 1.0]);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[must_use]
pub fn largest_fall<P: Polyline + ?Sized>(function: &P, distance: f32) -> f64 {
    if distance > 0.0 { max_above(function, -f64::from(distance), function).0 } else { 0.0 }
}

/// The largest distance of `function` above `other`, which is moved behind by `by`: at
/// either side of every vertex of both, between which they are linear. With the
/// depth and the channel; 0 if it is nowhere above.
fn max_above<A, B>(function: &A, by: f64, other: &B) -> (f64, f32, usize)
where
    A: Polyline + ?Sized,
    B: Polyline<Sum = A::Sum> + ?Sized,
{
    let mut worst = (0.0, 0.0, 0);
    let first = |function: &A| (function.vertex_count() > 0).then(|| function.sum_vertex(0));
    let any = first(function).or((other.vertex_count() > 0).then(|| other.sum_vertex(0)));
    let Some(any) = any else { return worst };
    let clear = zip(any.value, any.value, |_, _| 1.0);
    let (mut function, mut other) =
        (Moved::new(function, 0.0, clear), Moved::new(other, by, clear));
    loop {
        let z = function.next_depth().min(other.next_depth());
        if z == f64::INFINITY {
            return worst;
        }
        for (above, below) in function.advance(z).into_iter().zip(other.advance(z)) {
            let apart = zip(above, below, |above, below| above - below);
            for (channel, &apart) in apart.as_ref().iter().enumerate() {
                if apart > worst.0 {
                    worst = (apart, z as f32, channel);
                }
            }
        }
    }
}

/// A function that is moved behind and evaluated at ascending depths: in `f64`,
/// as sums of depths are no `f32`s.
struct Moved<'a, P: Polyline + ?Sized> {
    function: &'a P,
    by: f64,
    clear: P::Sum,
    /// Number of vertices before the next.
    passed: usize,
}

impl<'a, P: Polyline + ?Sized> Moved<'a, P> {
    const fn new(function: &'a P, by: f64, clear: P::Sum) -> Self {
        Self { function, by, clear, passed: 0 }
    }

    fn vertex(&self, index: usize) -> (f64, P::Sum) {
        let vertex = self.function.sum_vertex(index);
        (f64::from(vertex.z) + self.by, vertex.value)
    }

    /// The depth of the next vertex, infinite behind the last.
    fn next_depth(&self) -> f64 {
        if self.passed < self.function.vertex_count() {
            self.vertex(self.passed).0
        } else {
            f64::INFINITY
        }
    }

    /// The values from the light's side of `z` and at `z`, which is neither
    /// before the last nor behind the next vertex.
    fn advance(&mut self, z: f64) -> [P::Sum; 2] {
        let count = self.function.vertex_count();
        let previous = self.passed.checked_sub(1).map(|index| self.vertex(index));
        let before = match previous {
            None => self.clear,
            Some((_, value)) if self.passed == count => value,
            Some((from, value)) => {
                let (to, next) = self.vertex(self.passed);
                // The vertices of a step lie at one depth.
                let share = if to > from { (z - from) / (to - from) } else { 1.0 };
                zip(value, next, |value, next| value + (next - value) * share)
            }
        };
        let mut at = before;
        while self.next_depth() <= z {
            at = self.vertex(self.passed).1;
            self.passed += 1;
        }
        [before, at]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transmittance::Rgb;
    use crate::visibility::function::VisibilityFunction;
    use crate::visibility::vertex::Vertex;

    fn function(vertices: &[(f32, f32)]) -> VisibilityFunction<f32> {
        let vertices = vertices.iter().map(|&(z, value)| Vertex::new(z, value));
        VisibilityFunction::new(vertices.collect::<Vec<_>>()).unwrap()
    }

    /// The difference by evaluation at many depths: `f32` halves are exact.
    fn naive(stored: &VisibilityFunction<f32>, exact: &VisibilityFunction<f32>, error: f32) -> f64 {
        let mut worst = 0.0_f64;
        for step in 1..4000 {
            let z = step as f32 / 128.0;
            let apart = |a: f32, b: f32| f64::from(a) - f64::from(b);
            let [moved_before, moved_at] = match z > error {
                true => [exact.view().before(z - error), exact.view().at(z - error)],
                false => [1.0; 2],
            };
            worst = worst.max(apart(exact.view().at(z), stored.view().at(z)));
            worst = worst.max(apart(exact.view().before(z), stored.view().before(z)));
            worst = worst.max(apart(stored.view().before(z), moved_before));
            // As just behind z.
            worst = worst.max(apart(stored.view().at(z), moved_at));
        }
        worst
    }

    #[test]
    fn the_least_epsilon_is_what_every_depth_needs() {
        // Functions of few vertices on a grid, all the same seeds.
        let mut state = 5_u32;
        let mut next = |below: u32| {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            (state >> 16) % below
        };
        let mut some = || {
            let (mut z, mut value, mut vertices) = (1.0, 1.0, Vec::new());
            for _ in 0..next(6) {
                z += next(8) as f32 / 4.0 + 0.25;
                if next(2) == 0 || vertices.is_empty() {
                    vertices.push((z, value));
                }
                value *= 1.0 - next(5) as f32 / 8.0;
                vertices.push((z, value));
            }
            function(&vertices)
        };
        let mut moved = 0;
        for round in 0..2000 {
            let (stored, exact) = (some(), some());
            let error = [0.25, 0.5, 1.0, 4.0][round % 4];
            let found = VisibilityDifference::with_moved_depths(&stored, &exact, error);
            let expected = naive(&stored, &exact, error);
            let off = found.max() - expected;
            assert!(off.abs() < 1e-6, "{stored:?} {exact:?} {error} {off}");
            let between = VisibilityDifference::between(&stored, &exact);
            assert!(found.max() < between.max() + 1e-6 && found.mean() == between.mean());
            moved += u32::from(found.max() + 1e-6 < between.max());
        }
        assert!(moved > 200, "{moved}");
    }

    #[test]
    fn the_largest_fall_is_that_of_any_two_depths_so_far_apart() {
        let steps = function(&[(1.0, 1.0), (1.0, 0.75), (1.5, 0.75), (1.5, 0.25), (3.0, 0.0)]);
        for distance in [0.0, 0.25, 0.5, 0.75, 2.0] {
            let found = largest_fall(&steps, distance);
            let mut naive = 0.0_f64;
            for step in 0..4096_u16 {
                let z = f32::from(step) / 1024.0;
                let fall = |from: f32, to: f32| f64::from(from) - f64::from(to);
                naive = naive.max(fall(steps.view().at(z), steps.view().at(z + distance)));
                naive = naive.max(fall(steps.view().before(z), steps.view().before(z + distance)));
            }
            assert!((found - naive).abs() < 1e-6, "{distance}: {found} {naive}");
        }
        let coloured = [(1.0, Rgb::new(1.0, 1.0, 1.0)), (1.0, Rgb::new(0.5, 0.25, 1.0))];
        let coloured = VisibilityFunction::new(coloured.map(|(z, v)| Vertex::new(z, v))).unwrap();
        assert_eq!(largest_fall(&coloured, 1e-3), 0.75);
    }

    #[test]
    fn moved_vertices_are_within_nothing_and_others_are_not() {
        let exact = function(&[(1.0, 1.0), (1.0, 0.75), (2.0, 0.5), (4.0, 0.5), (4.0, 0.0)]);
        let moved = function(&[(1.25, 1.0), (1.25, 0.75), (2.125, 0.5), (4.0, 0.5), (4.0, 0.0)]);
        let within = |a, b, error| VisibilityDifference::with_moved_depths(a, b, error).max();
        assert_eq!(within(&moved, &exact, 0.25), 0.0);
        // Just before depth 1.25, of 1 and the ramp from 0.75 to 0.5.
        assert_eq!(within(&moved, &exact, 0.125), 0.28125);
        assert_eq!(within(&exact, &moved, 0.25), 0.3125);
        // A value that is off stays off, where it is.
        let off = function(&[(1.25, 1.0), (1.25, 0.75), (2.125, 0.5), (4.0, 0.5), (4.0, 0.125)]);
        let difference = VisibilityDifference::with_moved_depths(&off, &exact, 0.25);
        assert_eq!((difference.max(), difference.depth()), (0.125, 4.25));
        let clear = function(&[]);
        assert_eq!(within(&clear, &exact, 9.0), 1.0);
        assert_eq!(within(&exact, &clear, 9.0), 1.0);
    }

    #[test]
    fn channels_are_told_apart() {
        let step = |z: f32, to: Rgb| {
            let vertices = [Vertex::new(z, Rgb::new(1.0, 1.0, 1.0)), Vertex::new(z, to)];
            VisibilityFunction::new(vertices).unwrap()
        };
        let exact = step(2.0, Rgb::new(0.5, 0.5, 0.5));
        let moved = step(2.5, Rgb::new(0.5, 0.5, 0.75));
        let difference = VisibilityDifference::with_moved_depths(&moved, &exact, 0.5);
        assert_eq!((difference.max(), difference.channel()), (0.25, 2));
    }
}
