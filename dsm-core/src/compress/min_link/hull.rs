//! The side of a corridor that lines have to pass, as the hull of its corners.

/// A place in the plane of depth and value, in `f64`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point {
    pub(super) z: f64,
    pub(super) y: f64,
}

impl Point {
    pub(super) const fn new(z: f64, y: f64) -> Self {
        Self { z, y }
    }

    /// The same for the other side of a corridor, upside down.
    pub(super) const fn negated(self) -> Self {
        Self { z: self.z, y: -self.y }
    }
}

/// A straight line through a place. One whose slope is infinite stands for no bound:
/// it lies above every place behind if it rises, and below if it falls.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    through: Point,
    slope: f64,
}

impl Line {
    /// The line through two places, the second behind the first.
    #[inline(always)]
    pub(super) fn between(from: Point, to: Point) -> Self {
        Self { through: to, slope: (to.y - from.y) / (to.z - from.z) }
    }

    pub(super) const fn with_slope(through: Point, slope: f64) -> Self {
        Self { through, slope }
    }

    pub(super) const fn above_all(through: Point) -> Self {
        Self { through, slope: f64::INFINITY }
    }

    pub(super) const fn below_all(through: Point) -> Self {
        Self { through, slope: f64::NEG_INFINITY }
    }

    pub(super) const fn is_bound(&self) -> bool {
        self.slope.is_finite()
    }

    pub(super) const fn through(&self) -> Point {
        self.through
    }

    pub(super) const fn slope(&self) -> f64 {
        self.slope
    }

    /// The value at `z`; NaN where a line that stands for no bound starts.
    #[inline(always)]
    pub(super) fn at(&self, z: f64) -> f64 {
        self.through.y + self.slope * (z - self.through.z)
    }
}

/// Corners that lines must not pass below: of their upper hull what tangents
/// from places behind may still touch. Corners come in ascending depth, so that
/// tangents move on only, and every corner is dropped once at most.
#[derive(Clone, Debug, Default)]
pub(super) struct Hull {
    points: Vec<Point>,
    /// The corner that the last tangent touched; none before it counts any more.
    head: usize,
    /// The corner that holds up the extreme line on this side.
    support: usize,
}

impl Hull {
    pub(super) fn clear(&mut self) {
        self.points.clear();
        (self.head, self.support) = (0, 0);
    }

    pub(super) const fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Forgets the corners before the support.
    pub(super) const fn start_at_support(&mut self) {
        self.head = self.support;
    }

    /// Has the last corner hold up the extreme line.
    pub(super) const fn support_last(&mut self) {
        self.support = self.points.len().saturating_sub(1);
    }

    pub(super) fn support(&self) -> Option<Point> {
        self.points.get(self.support).copied()
    }

    pub(super) fn last(&self) -> Option<Point> {
        self.points.last().copied()
    }

    /// The corner before `to` from which a line there falls most, so that no corner is
    /// above it. None without such corners.
    #[inline(always)]
    pub(super) fn tangent(&mut self, to: Point) -> Option<Point> {
        let mut touched = *self.points.get(self.head)?;
        if touched.z >= to.z {
            return None;
        }
        while let Some(&next) = self.points.get(self.head + 1) {
            let is_lower = next.z < to.z
                && (to.y - next.y) * (to.z - touched.z) <= (to.y - touched.y) * (to.z - next.z);
            if !is_lower {
                break;
            }
            touched = next;
            self.head += 1;
        }
        Some(touched)
    }

    /// Adds a corner behind all others.
    #[inline(always)]
    pub(super) fn push(&mut self, point: Point) {
        self.push_above(point, self.head.max(self.support));
    }

    /// Adds a corner behind all others that holds up the extreme line now.
    #[inline(always)]
    pub(super) fn push_support(&mut self, point: Point) {
        self.push_above(point, self.head);
        self.support = self.points.len() - 1;
    }

    /// Adds a corner and drops those behind index `kept` that are under the hull then.
    #[inline(always)]
    fn push_above(&mut self, point: Point, kept: usize) {
        while let [.., before, last] = &self.points[kept..] {
            let is_under = (last.y - before.y) * (point.z - before.z)
                <= (point.y - before.y) * (last.z - before.z);
            if !is_under {
                break;
            }
            self.points.pop();
        }
        self.points.push(point);
    }
}
