//! The pixels that a shadow ray crosses, one after the other.

/// A ray from a receiver: straight in raster positions and u, the gain of w = 1 / depth.
#[derive(Clone, Copy, Debug)]
pub(super) struct MediaRay {
    /// The pixel of the receiver, and where it is in it.
    pub(super) corner: [f64; 2],
    pub(super) within: [f64; 2],
    /// w of the receiver.
    pub(super) w: f64,
    /// Pixels per unit of u.
    pub(super) slope: [f64; 2],
    /// The u that the ray goes to.
    pub(super) end: f64,
}

/// The part of a map that holds something.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Extent {
    /// First column and row.
    pub(super) low: [u32; 2],
    /// The last ones, and one more.
    pub(super) high: [u32; 2],
    /// Least and greatest w.
    pub(super) w: [f64; 2],
}

impl MediaRay {
    /// Calls `meet` with each pixel of `extent` that the ray crosses, and the w where it
    /// enters and leaves it, until that answers false. O(columns + rows).
    #[inline(always)]
    pub(super) fn walk(&self, extent: &Extent, mut meet: impl FnMut([u32; 2], [f64; 2]) -> bool) {
        let Self { corner, within, w, slope, end } = self;
        // Borders are told from the receiver's pixel.
        let border = |axis: usize, at: f64| ((at - corner[axis]) - within[axis]) / slope[axis];
        let (mut u, mut end) = ((extent.w[0] - w).max(0.0), end.min(extent.w[1] - w));
        for axis in 0..2 {
            let sides = [extent.low[axis], extent.high[axis]].map(f64::from);
            if slope[axis] == 0.0 {
                let at = corner[axis] + within[axis];
                if !(sides[0] <= at && at < sides[1]) {
                    return;
                }
            } else {
                let [a, b] = sides.map(|side| border(axis, side));
                (u, end) = (u.max(a.min(b)), end.min(a.max(b)));
            }
        }
        // Not with NaN.
        let has_way = u < end;
        if !has_way {
            return;
        }
        let mut cell = [0; 2];
        let mut next = [f64::INFINITY; 2];
        for axis in 0..2 {
            let at = (corner[axis] + (within[axis] + slope[axis] * u).floor()) as i64;
            let (low, high) = (extent.low[axis].into(), i64::from(extent.high[axis]) - 1);
            cell[axis] = at.clamp(low, high) as u32;
            if slope[axis] != 0.0 {
                let ahead = u32::from(slope[axis] > 0.0);
                next[axis] = border(axis, (cell[axis] + ahead).into());
            }
        }
        loop {
            let axis = usize::from(next[1] < next[0]);
            let to = next[axis].min(end);
            if to > u {
                if !meet(cell, [w + u, w + to]) {
                    return;
                }
                u = to;
            }
            if to >= end {
                return;
            }
            if slope[axis] > 0.0 {
                cell[axis] += 1;
                if cell[axis] >= extent.high[axis] {
                    return;
                }
                next[axis] = border(axis, (cell[axis] + 1).into());
            } else {
                if cell[axis] <= extent.low[axis] {
                    return;
                }
                cell[axis] -= 1;
                next[axis] = border(axis, cell[axis].into());
            }
        }
    }
}
