//! The slopes that a segment may still have.

use crate::{SumVertex, Transmittance, Vertex};

/// The window of slopes with which a segment from a fixed origin passes
/// through the target windows of all vertices seen so far, one window a
/// channel (Lokovic & Veach 2000, §3.3 and figure 5).
#[derive(Clone, Copy, Debug)]
pub(super) struct SlopeWindow<T: Transmittance> {
    origin: SumVertex<T>,
    /// Depth of the last vertex that was let in; the origin's before that.
    last: f32,
    /// 1 / (`last` − origin's z). NaN before the first vertex: a vertex at
    /// the origin's own depth has no slope, so NaN bounds refuse it.
    per_depth: f64,
    /// A vertex of value v asks for a rise of at least v − `below`.
    below: T::Sum,
    /// A vertex of value v asks for a rise of at most v − `above`.
    above: T::Sum,
    /// The deepest fall that any vertex may ask for, ≤ 0.
    floor: T::Sum,
    lowest: T::Sum,
    highest: T::Sum,
}

/// How far around a vertex its target window reaches.
#[derive(Clone, Copy, Debug)]
pub(super) struct Target<T: Transmittance> {
    /// How far below the vertex.
    pub(super) down: f64,
    /// How far above the vertex.
    pub(super) up: f64,
    /// The value that no window reaches below.
    pub(super) floor: T::Sum,
    /// The highest slope of any segment.
    pub(super) highest_slope: f64,
}

impl<T: Transmittance> SlopeWindow<T> {
    /// A window that lets nothing in, below `value`.
    pub(super) fn closed(value: T::Sum) -> Self {
        let nothing = T::sum_from_channels(|_| f64::NAN);
        Self {
            origin: Vertex::new(f32::NAN, value),
            last: f32::NAN,
            per_depth: f64::NAN,
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
            last: origin.z,
            per_depth: f64::NAN,
            below: T::sum_from_channels(|channel| value[channel] + target.down),
            above: T::sum_from_channels(|channel| value[channel] - target.up),
            floor: T::sum_from_channels(|channel| target.floor.as_ref()[channel] - value[channel]),
            lowest: T::sum_from_channels(|_| f64::NEG_INFINITY),
            highest: T::sum_from_channels(|_| target.highest_slope),
        }
    }

    /// Promises that no further vertex lies above `value` by more than
    /// `slack`, so that the lower bounds never ask for a rise, whatever
    /// rounding did to the origin.
    #[inline]
    pub(super) fn never_rise_above(&mut self, value: &T::Sum, slack: f64) {
        for (below, &value) in self.below.as_mut().iter_mut().zip(value.as_ref()) {
            *below = below.max(value + slack);
        }
    }

    /// Where the segment starts; z is NaN if the window is closed.
    #[inline]
    pub(super) const fn origin(&self) -> SumVertex<T> {
        self.origin
    }

    /// Whether any vertex behind the origin was let in.
    #[inline]
    pub(super) fn is_open(&self) -> bool {
        self.last > self.origin.z
    }

    /// Narrows the window to let `vertex` in; false, and the window
    /// unchanged, if no slope is left in some channel or if `vertex` stands
    /// at the origin's depth.
    #[inline(always)]
    pub(super) fn narrow(&mut self, vertex: &SumVertex<T>) -> bool {
        // The two vertices of a step share their reciprocal.
        let per_depth = if vertex.z == self.last {
            self.per_depth
        } else {
            (f64::from(vertex.z) - f64::from(self.origin.z)).recip()
        };
        let (mut lowest, mut highest) = (self.lowest, self.highest);
        let mut fits = true;
        for channel in 0..T::CHANNELS {
            let value = vertex.value.as_ref()[channel];
            let fall = value - self.below.as_ref()[channel];
            let floor = self.floor.as_ref()[channel];
            let low = if fall > floor { fall } else { floor } * per_depth;
            let high = (value - self.above.as_ref()[channel]) * per_depth;
            // Ordered so that a NaN gets through to the last comparison.
            let (old_low, old_high) = (lowest.as_ref()[channel], highest.as_ref()[channel]);
            let low = if old_low > low { old_low } else { low };
            let high = if old_high < high { old_high } else { high };
            lowest.as_mut()[channel] = low;
            highest.as_mut()[channel] = high;
            fits &= low <= high;
        }
        if fits {
            self.lowest = lowest;
            self.highest = highest;
            self.per_depth = per_depth;
            self.last = vertex.z;
        }
        fits
    }

    /// Whether the segment may go straight to `vertex`, which stands behind
    /// the origin.
    pub(super) fn admits(&self, vertex: &SumVertex<T>) -> bool {
        let length = f64::from(vertex.z) - f64::from(self.origin.z);
        (0..T::CHANNELS).all(|channel| {
            let rise = vertex.value.as_ref()[channel] - self.origin.value.as_ref()[channel];
            let slope = rise / length;
            (self.lowest.as_ref()[channel]..=self.highest.as_ref()[channel]).contains(&slope)
        })
    }

    /// Where the segment ends: at the last vertex that was let in, with the
    /// middle of the slopes that are left.
    #[inline]
    pub(super) fn end(&self) -> SumVertex<T> {
        let length = f64::from(self.last) - f64::from(self.origin.z);
        let value = T::sum_from_channels(|channel| {
            let slope = 0.5 * (self.lowest.as_ref()[channel] + self.highest.as_ref()[channel]);
            self.origin.value.as_ref()[channel] + slope * length
        });
        Vertex::new(self.last, value)
    }
}
