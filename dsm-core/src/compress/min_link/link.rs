//! All straight lines through a stretch of a corridor.

use super::hull::{Hull, Line, Point};

/// Every line that passes the corners so far, between its two extremes: the one
/// that is lowest where the corridor goes on and the one that is highest there
/// (O'Rourke 1981). O(1) amortised a corner.
#[derive(Clone, Debug)]
pub(super) struct Link {
    /// What lines must not pass below.
    floor: Hull,
    /// What they must not pass above, upside down.
    ceiling: Hull,
    lowest: Line,
    highest: Line,
}

impl Default for Link {
    fn default() -> Self {
        let origin = Point::new(0.0, 0.0);
        Self {
            floor: Hull::default(),
            ceiling: Hull::default(),
            lowest: Line::below_all(origin),
            highest: Line::above_all(origin),
        }
    }
}

impl Link {
    /// All lines that cross the vertical from `low` to `high`.
    pub(super) fn start_at_step(&mut self, low: Point, high: Point) {
        self.clear();
        self.floor.push_support(low);
        self.ceiling.push_support(high.negated());
        self.lowest = Line::below_all(low);
        self.highest = Line::above_all(high);
    }

    /// All lines that fall through the horizontal from `from` on.
    pub(super) fn start_at_plateau(&mut self, from: Point) {
        self.clear();
        self.floor.push_support(from);
        self.lowest = Line::below_all(from);
        self.highest = Line::with_slope(from, 0.0);
    }

    fn clear(&mut self) {
        self.floor.clear();
        self.ceiling.clear();
    }

    /// True if nothing bounds the lines from above yet.
    pub(super) const fn has_no_ceiling(&self) -> bool {
        self.ceiling.is_empty()
    }

    /// Leaves the lines that pass at or below `corner`; false, and nothing changed, if
    /// there are none.
    #[inline(always)]
    pub(super) fn pass_below(&mut self, corner: Point) -> bool {
        if corner.y < self.lowest.at(corner.z) {
            return false;
        }
        if corner.y >= self.highest.at(corner.z) {
            self.ceiling.push(corner.negated());
        } else if let Some(touched) = self.floor.tangent(corner) {
            self.highest = Line::between(touched, corner);
            self.ceiling.push_support(corner.negated());
        } else {
            self.ceiling.push(corner.negated());
        }
        true
    }

    /// Leaves the lines that pass at or above `corner`; false, and nothing changed, if
    /// there are none.
    #[inline(always)]
    pub(super) fn pass_above(&mut self, corner: Point) -> bool {
        if corner.y > self.highest.at(corner.z) {
            return false;
        }
        if corner.y <= self.lowest.at(corner.z) {
            self.floor.push(corner);
        } else if let Some(touched) = self.ceiling.tangent(corner.negated()) {
            self.lowest = Line::between(touched.negated(), corner);
            self.floor.push_support(corner);
        } else {
            self.floor.push(corner);
        }
        true
    }

    /// The lowest line, whose part from its last touch of the floor on bounds what
    /// this link reaches.
    pub(super) const fn lowest(&self) -> Line {
        self.lowest
    }

    /// The highest line, whose part from its last touch of the ceiling on bounds
    /// what this link reaches.
    pub(super) const fn highest(&self) -> Line {
        self.highest
    }

    /// The least and the largest value at `z`, not before any corner.
    pub(super) fn range(&self, z: f64) -> [f64; 2] {
        let [lowest, highest] = [&self.lowest, &self.highest];
        [
            if lowest.is_bound() { lowest.at(z) } else { f64::NEG_INFINITY },
            if highest.is_bound() { highest.at(z) } else { f64::INFINITY },
        ]
    }

    /// Goes on with all lines that cross the lowest one between its last touch of
    /// the floor, which is returned, and `exit`, where it leaves by the ceiling;
    /// none if that is at a corner's own depth.
    pub(super) fn cross_lowest(&mut self, exit: Option<Point>) -> Option<Point> {
        let touch = self.floor.support();
        self.floor.start_at_support();
        self.ceiling.clear();
        self.highest = self.lowest;
        self.lowest = Line::below_all(self.lowest.through());
        if let Some(exit) = exit {
            self.ceiling.push_support(exit.negated());
            // Where the floor levels out it may be known behind the exit already.
            if let Some(last) = self.floor.last().filter(|last| last.z > exit.z) {
                self.floor.support_last();
                self.lowest = Line::between(exit, last);
            }
        }
        touch
    }

    /// Goes on with all lines that cross the highest one between its last touch of
    /// the ceiling, which is returned, and `exit`, where it leaves by the floor.
    pub(super) fn cross_highest(&mut self, exit: Point) -> Option<Point> {
        let touch = self.ceiling.support().map(Point::negated);
        self.ceiling.start_at_support();
        self.floor.clear();
        self.lowest = self.highest;
        self.floor.push_support(exit);
        // The ceiling is there already at the depth where the floor was too high.
        let last = self.ceiling.last().map(Point::negated);
        self.highest = match last.filter(|last| last.z > exit.z) {
            Some(last) => {
                self.ceiling.support_last();
                Line::between(exit, last)
            }
            None => Line::above_all(self.highest.through()),
        };
        touch
    }

    /// A line amid those that are left, one that does not rise.
    pub(super) fn middle(&self, z: f64) -> Line {
        let (lowest, highest) = (self.lowest, self.highest);
        match (lowest.is_bound(), highest.is_bound()) {
            (true, true) => {
                // Any mean of the two is a line of the link.
                let [low, high] = [lowest.slope(), highest.slope()];
                let share = if low + high <= 0.0 { 0.5 } else { high / (high - low) };
                let mean = |low: f64, high: f64| high + (low - high) * share;
                let through = Point::new(z, mean(lowest.at(z), highest.at(z)));
                Line::with_slope(through, mean(low, high).min(0.0))
            }
            (false, true) if highest.slope() > 0.0 => Line::with_slope(highest.through(), 0.0),
            (false, true) => highest,
            (true, false) => lowest,
            (false, false) => Line::with_slope(lowest.through(), 0.0),
        }
    }
}
