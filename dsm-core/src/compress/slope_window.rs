//! The window of slopes that a segment may have.

use crate::transmittance::Transmittance;
use crate::visibility::vertex::{SumVertex, Vertex};

/// The larger of two; `b` if either is NaN. One instruction on x86-64, unlike
/// `f64::max`.
#[inline(always)]
pub(super) fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The smaller of two; `b` if either is NaN.
#[inline(always)]
pub(super) fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The window of slopes with which a segment from a fixed origin passes
/// through the target windows of all vertices seen so far, one window a
/// channel (Lokovic & Veach 2000, §3.3 and figure 5).
#[derive(Clone, Copy, Debug)]
pub(super) struct SlopeWindow<T: Transmittance> {
    origin: SumVertex<T>,
    /// The origin's z.
    start: f64,
    /// Depth of the last vertex that was let in; the origin's before that.
    last: f32,
    /// A vertex of value v asks for a rise of at least v − `below`.
    below: T::Sum,
    /// A vertex of value v asks for a rise of at most v − `above`.
    above: T::Sum,
    /// The deepest fall that any vertex may ask for, ≤ 0.
    floor: T::Sum,
    lowest: T::Sum,
    highest: T::Sum,
}

/// The target window around a vertex.
#[derive(Clone, Copy, Debug)]
pub(super) struct Target<T: Transmittance> {
    /// Its extent below the vertex.
    pub(super) down: f64,
    /// Its extent above the vertex.
    pub(super) up: f64,
    /// The value that no window reaches below.
    pub(super) floor: T::Sum,
}

impl<T: Transmittance> SlopeWindow<T> {
    /// A window that lets nothing in, below `value`.
    pub(super) fn closed(value: T::Sum) -> Self {
        let nothing = T::sum_from_channels(|_| f64::NAN);
        Self {
            origin: Vertex::new(f32::NAN, value),
            start: f64::NAN,
            last: f32::NAN,
            below: nothing,
            above: nothing,
            floor: nothing,
            lowest: nothing,
            highest: nothing,
        }
    }

    /// All slopes from `origin`, to be narrowed by the windows of `target`.
    #[inline]
    pub(super) fn from_origin(origin: SumVertex<T>, target: &Target<T>) -> Self {
        let value = origin.value.as_ref();
        Self {
            origin,
            start: f64::from(origin.z),
            last: origin.z,
            below: T::sum_from_channels(|channel| value[channel] + target.down),
            above: T::sum_from_channels(|channel| value[channel] - target.up),
            floor: T::sum_from_channels(|channel| target.floor.as_ref()[channel] - value[channel]),
            lowest: T::sum_from_channels(|_| f64::NEG_INFINITY),
            highest: T::sum_from_channels(|_| f64::INFINITY),
        }
    }

    /// Promises that no further vertex lies above `value` by more than
    /// `slack`, so that the lower bounds never ask for a rise, whatever
    /// rounding did to the origin.
    #[inline]
    pub(super) fn never_rise_above(&mut self, value: &T::Sum, slack: f64) {
        for (below, &value) in self.below.as_mut().iter_mut().zip(value.as_ref()) {
            *below = larger(*below, value + slack);
        }
    }

    /// The start of the segment; z is NaN if the window is closed.
    #[inline]
    pub(super) const fn origin(&self) -> SumVertex<T> {
        self.origin
    }

    /// True if there is no segment.
    #[inline]
    pub(super) const fn is_closed(&self) -> bool {
        self.start.is_nan()
    }

    /// True if any vertex behind the origin was let in.
    #[inline]
    pub(super) fn is_open(&self) -> bool {
        self.last > self.origin.z
    }

    /// Narrows the window to let the step at `z` in that falls from `before`
    /// to `after`, which may be equal; false, and the window unchanged, if no
    /// slope is left in some channel or if `z` is not behind the origin.
    #[inline(always)]
    pub(super) fn narrow(&mut self, z: f32, before: &T::Sum, after: &T::Sum) -> bool {
        let length = f64::from(z) - self.start;
        if length.is_nan() || length <= 0.0 {
            return false;
        }
        let per_depth = length.recip();
        let (mut lowest, mut highest) = (self.lowest, self.highest);
        let mut fits = true;
        for channel in 0..T::CHANNELS {
            let fall = before.as_ref()[channel] - self.below.as_ref()[channel];
            let fall = larger(fall, self.floor.as_ref()[channel]);
            let rise = after.as_ref()[channel] - self.above.as_ref()[channel];
            let low = larger(fall * per_depth, lowest.as_ref()[channel]);
            let high = smaller(rise * per_depth, highest.as_ref()[channel]);
            lowest.as_mut()[channel] = low;
            highest.as_mut()[channel] = high;
            fits &= low <= high;
        }
        if fits {
            self.lowest = lowest;
            self.highest = highest;
            self.last = z;
        }
        fits
    }

    /// Narrows the window to let `vertex` in; false, and the window
    /// unchanged, if no slope is left or if it stands at the origin's depth.
    #[inline(always)]
    pub(super) fn narrow_by(&mut self, vertex: &SumVertex<T>) -> bool {
        self.narrow(vertex.z, &vertex.value, &vertex.value)
    }

    /// Narrows the window by vertex after vertex and returns those that are
    /// left: the first of them doesn't fit.
    #[inline(always)]
    pub(super) fn narrow_by_all<'a>(
        &mut self,
        mut vertices: &'a [SumVertex<T>],
    ) -> &'a [SumVertex<T>] {
        loop {
            vertices = match vertices {
                [before, after, rest @ ..] if after.z <= before.z => {
                    if self.narrow(before.z, &before.value, &after.value) {
                        rest
                    } else if self.narrow_by(before) {
                        return &vertices[1..];
                    } else {
                        return vertices;
                    }
                }
                [vertex, rest @ ..] if self.narrow_by(vertex) => rest,
                _ => return vertices,
            };
        }
    }

    /// True if the segment may go straight to `vertex`, which stands behind the
    /// origin.
    pub(super) fn admits(&self, vertex: &SumVertex<T>) -> bool {
        let length = f64::from(vertex.z) - self.start;
        (0..T::CHANNELS).all(|channel| {
            let rise = vertex.value.as_ref()[channel] - self.origin.value.as_ref()[channel];
            let slope = rise / length;
            (self.lowest.as_ref()[channel]..=self.highest.as_ref()[channel]).contains(&slope)
        })
    }

    /// The end of the segment: at the last vertex that was let in, with the middle
    /// of the slopes that are left.
    #[inline]
    pub(super) fn end(&self) -> SumVertex<T> {
        let half = 0.5 * (f64::from(self.last) - self.start);
        let value = T::sum_from_channels(|channel| {
            let slopes = self.lowest.as_ref()[channel] + self.highest.as_ref()[channel];
            self.origin.value.as_ref()[channel] + slopes * half
        });
        Vertex::new(self.last, value)
    }
}
