//! Cubic curves: their segments in Bézier form.

/// How a cubic curve goes by its control points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Basis {
    Linear,
    Bezier,
    BSpline,
    CatmullRom,
}

/// What a curve does at its ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wrap {
    Nonperiodic,
    Periodic,
    Pinned,
}

/// One curve's layout.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    pub(super) basis: Basis,
    pub(super) wrap: Wrap,
    /// Control points, ≥ 1.
    pub(super) count: usize,
}

/// Values that curves interpolate: points and widths.
pub(super) trait Blend: Copy {
    /// a · x + b · y + c · z.
    fn blend(parts: [(f64, Self); 3]) -> Self;
}

impl Blend for f64 {
    fn blend(parts: [(f64, Self); 3]) -> Self {
        parts.iter().map(|(weight, value)| weight * value).sum()
    }
}

impl Blend for glam::DVec3 {
    fn blend(parts: [(f64, Self); 3]) -> Self {
        parts.iter().map(|&(weight, value)| value * weight).sum()
    }
}

impl Layout {
    /// Number of segments, 0 for too few points.
    pub(super) fn segments(&self) -> usize {
        let count = self.count;
        match (self.basis, self.wrap) {
            (Basis::Linear, Wrap::Periodic) if count >= 3 => count,
            (Basis::Linear, _) => count - 1,
            (Basis::Bezier, Wrap::Periodic) => count / 3,
            (Basis::Bezier, _) => (count - 1) / 3,
            (_, Wrap::Periodic) if count >= 3 => count,
            (_, Wrap::Pinned) => count - 1,
            _ => count.saturating_sub(3),
        }
    }

    /// Number of ends of segments: of values that go linearly.
    pub(super) fn varying(&self) -> usize {
        match (self.segments(), self.wrap) {
            (0, _) => 1,
            (segments, Wrap::Periodic) => segments,
            (segments, _) => segments + 1,
        }
    }

    /// The four Bézier values of a segment, from `at`: a value by its control point.
    /// Pinned curves have one more at either end, the mirror image of the second.
    pub(super) fn bezier<T: Blend>(&self, segment: usize, at: impl Fn(usize) -> T) -> [T; 4] {
        let value = |index: isize| {
            let count = self.count as isize;
            match self.wrap {
                Wrap::Periodic => at(index.rem_euclid(count) as usize),
                Wrap::Pinned if index < 0 => {
                    let second = at(1.min(self.count - 1));
                    T::blend([(2.0, at(0)), (-1.0, second), (0.0, second)])
                }
                Wrap::Pinned if index >= count => {
                    let second = at(self.count.saturating_sub(2));
                    T::blend([(2.0, at(self.count - 1)), (-1.0, second), (0.0, second)])
                }
                _ => at(index.clamp(0, count - 1) as usize),
            }
        };
        let segment = segment as isize;
        // The first of the segment's four control points.
        let first = match (self.basis, self.wrap) {
            (Basis::Bezier, _) => 3 * segment,
            (Basis::Linear, _) => segment,
            (_, Wrap::Pinned) => segment - 1,
            (_, _) => segment,
        };
        let [a, b, c, d] = [0, 1, 2, 3].map(|offset| value(first + offset));
        let mixed = |x, y, z| T::blend([x, y, z]);
        match self.basis {
            Basis::Bezier => [a, b, c, d],
            Basis::Linear => [
                a,
                mixed((2.0 / 3.0, a), (1.0 / 3.0, b), (0.0, b)),
                mixed((1.0 / 3.0, a), (2.0 / 3.0, b), (0.0, b)),
                b,
            ],
            Basis::BSpline => [
                mixed((1.0 / 6.0, a), (4.0 / 6.0, b), (1.0 / 6.0, c)),
                mixed((0.0, a), (2.0 / 3.0, b), (1.0 / 3.0, c)),
                mixed((0.0, a), (1.0 / 3.0, b), (2.0 / 3.0, c)),
                mixed((1.0 / 6.0, b), (4.0 / 6.0, c), (1.0 / 6.0, d)),
            ],
            Basis::CatmullRom => [
                b,
                mixed((-1.0 / 6.0, a), (1.0, b), (1.0 / 6.0, c)),
                mixed((1.0 / 6.0, b), (1.0, c), (-1.0 / 6.0, d)),
                c,
            ],
        }
    }
}

/// A Bézier segment's value at `t` in [0, 1].
pub(super) fn evaluate<T: Blend>([a, b, c, d]: [T; 4], t: f64) -> T {
    let s = 1.0 - t;
    let inner = T::blend([(s * s * s, a), (3.0 * s * s * t, b), (3.0 * s * t * t, c)]);
    T::blend([(1.0, inner), (t * t * t, d), (0.0, d)])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ends(basis: Basis, wrap: Wrap, points: &[f64]) -> Vec<[f64; 2]> {
        let layout = Layout { basis, wrap, count: points.len() };
        let segment = |index| {
            let bezier = layout.bezier(index, |at| points[at]);
            [evaluate(bezier, 0.0), evaluate(bezier, 1.0)]
        };
        (0..layout.segments()).map(segment).collect()
    }

    #[test]
    fn curves_begin_and_end_where_their_kind_does() {
        let points = [0.0, 6.0, 0.0, 12.0, 6.0];
        let near = |found: Vec<[f64; 2]>, expected: &[[f64; 2]]| {
            assert_eq!(found.len(), expected.len());
            let pairs = found.iter().flatten().zip(expected.iter().flatten());
            pairs.for_each(|(a, b)| assert!((a - b).abs() < 1e-12, "{found:?}"));
        };
        near(ends(Basis::BSpline, Wrap::Nonperiodic, &points), &[[4.0, 3.0], [3.0, 9.0]]);
        let pinned = ends(Basis::BSpline, Wrap::Pinned, &points);
        near(pinned, &[[0.0, 4.0], [4.0, 3.0], [3.0, 9.0], [9.0, 6.0]]);
        near(ends(Basis::CatmullRom, Wrap::Nonperiodic, &points), &[[6.0, 0.0], [0.0, 12.0]]);
        assert_eq!(ends(Basis::CatmullRom, Wrap::Periodic, &points).len(), 5);
        near(ends(Basis::Bezier, Wrap::Periodic, &points[..3]), &[[0.0, 0.0]]);
        near(ends(Basis::Bezier, Wrap::Pinned, &points[..4]), &[[0.0, 12.0]]);
        assert_eq!(ends(Basis::Linear, Wrap::Periodic, &points).len(), 5);
    }
}
