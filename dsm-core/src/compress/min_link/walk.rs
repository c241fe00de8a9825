//! The path of fewest links through a corridor.

use super::hull::{Line, Point};
use super::link::Link;
use super::rungs::{self, Bounds};

/// Of one channel.
type Rung = rungs::Rung<[f64; 1]>;

/// The line that the last link follows, and the depths between which the next
/// one crosses it.
#[derive(Clone, Copy, Debug)]
struct Window {
    line: Line,
    from: f64,
    to: f64,
}

/// Where the first link of a stretch starts.
#[derive(Clone, Copy, Debug)]
enum Start {
    /// On the plateau of value 1, between these depths.
    Plateau([f64; 2]),
    /// At a step, between these two values.
    Step { z: f64, low: f64, high: f64 },
}

/// Finds the corners of a monotone path of fewest links through a corridor (Suri
/// 1986; in a corridor between two functions: Imai & Iri 1986).
///
/// Link after link goes as far as any can: until no line is left that passes all
/// corners since the last window. What a link reaches ends at its window, the part
/// of the last line that was possible from where it touches one side of the
/// corridor to where it leaves by the other; the next link is any line that crosses
/// the window. So no path has fewer links. O(n).
#[derive(Clone, Debug, Default)]
pub(super) struct Walk {
    link: Link,
    start: Option<Start>,
    window: Option<Window>,
    /// The corners so far; two at one depth are a step.
    path: Vec<Point>,
}

impl Walk {
    /// The corners of the path through the corridor of `rungs`, the first at value 1,
    /// the last at `bounds.last`.
    pub(super) fn run(&mut self, rungs: &[Rung], bounds: &Bounds) -> &mut Vec<Point> {
        self.path.clear();
        self.window = None;
        let Some((first, rest)) = rungs.split_first() else { return &mut self.path };
        let z = first.start;
        if rest.is_empty() {
            self.path.extend([Point::new(z, 1.0), Point::new(z, bounds.last)]);
            return &mut self.path;
        }
        if bounds.high(first.after[0]) < 1.0 {
            self.path.push(Point::new(z, 1.0));
            self.start_at_step(z, first.after[0], bounds);
        } else {
            self.start = Some(Start::Plateau([z; 2]));
            self.link.start_at_plateau(Point::new(z, 1.0));
        }
        if !self.has_ended(first, bounds) {
            self.pass(first, rest, bounds);
        }
        &mut self.path
    }

    /// Passes all rungs behind the first.
    fn pass(&mut self, first: &Rung, rest: &[Rung], bounds: &Bounds) {
        let mut near = *first;
        let mut is_above = bounds.low(near.after[0]) > bounds.last;
        for (index, rung) in rest.iter().enumerate() {
            let is_last = index + 1 == rest.len();
            let low = bounds.low(rung.before[0]);
            let high = if is_last { bounds.last } else { bounds.high(rung.after[0]) };
            if low > high {
                self.reach_step(&near, rung, bounds);
                if is_last {
                    self.path.push(Point::new(rung.start, bounds.last));
                    return;
                }
                self.start_at_step(rung.start, rung.after[0], bounds);
                if self.has_ended(rung, bounds) {
                    return;
                }
                is_above = true;
            } else {
                if is_above && low <= bounds.last {
                    // From here on the path may have ended.
                    is_above = false;
                    let z = crossing(near.near(0), rung.far(0), bounds.last + bounds.below);
                    self.pass_above(Point::new(z, bounds.last), &near, rung, bounds);
                }
                self.pass_below(Point::new(rung.start, high), &near, rung, bounds);
                if is_above {
                    self.pass_above(Point::new(rung.end, low), &near, rung, bounds);
                }
            }
            near = *rung;
        }
        self.reach_end(near.end, bounds);
    }

    /// Starts at a step down to where V is `after`.
    fn start_at_step(&mut self, z: f64, after: f64, bounds: &Bounds) {
        let (low, high) = (bounds.low(after), bounds.high(after));
        self.start = Some(Start::Step { z, low, high });
        self.window = None;
        self.link.start_at_step(Point::new(z, low), Point::new(z, high));
    }

    /// Ends the path at a step whose far side may have the last value.
    fn has_ended(&mut self, rung: &Rung, bounds: &Bounds) -> bool {
        let ends = matches!(self.start, Some(Start::Step { low, .. }) if low <= bounds.last);
        if ends {
            self.path.push(Point::new(rung.start, bounds.last));
        }
        ends
    }

    #[inline(always)]
    fn pass_below(&mut self, corner: Point, near: &Rung, rung: &Rung, bounds: &Bounds) {
        if let Some(Start::Plateau(range)) = &mut self.start
            && self.window.is_none()
            && self.link.has_no_ceiling()
        {
            range[1] = corner.z;
            if corner.y >= 1.0 {
                return;
            }
            if bounds.high(rung.before[0]) < 1.0 {
                // The plateau ends inside a ramp.
                let z = crossing(near.near(0), rung.far(0), 1.0 - bounds.above);
                range[1] = z;
                self.link.pass_below(Point::new(z, 1.0));
            }
        }
        // Twice if the next link, too, ends between the rungs.
        for _ in 0..3 {
            if self.link.pass_below(corner) {
                return;
            }
            self.leave_by_the_ceiling(near, rung, bounds);
        }
    }

    #[inline(always)]
    fn pass_above(&mut self, corner: Point, near: &Rung, rung: &Rung, bounds: &Bounds) {
        // Twice if the next link, too, ends between the rungs.
        for _ in 0..3 {
            if self.link.pass_above(corner) {
                return;
            }
            self.leave_by_the_floor(corner, near, rung, bounds);
        }
    }

    /// Ends a link whose lowest line leaves the corridor between two rungs.
    #[inline(never)]
    fn leave_by_the_ceiling(&mut self, near: &Rung, rung: &Rung, bounds: &Bounds) {
        let line = self.link.lowest();
        let far = Point::new(rung.start, bounds.high(rung.before[0]));
        // At the rung itself the next corner bounds what follows.
        let exit = (line.at(far.z) > far.y)
            .then(|| meeting(&line, Point::new(near.end, bounds.high(near.after[0])), far));
        let touch = self.link.cross_lowest(exit);
        let to = exit.map_or(far.z, |exit| exit.z);
        self.follow(Window { line, from: touch.map_or(to, |touch| touch.z), to });
    }

    /// Ends a link whose highest line leaves the corridor before `corner`.
    #[inline(never)]
    fn leave_by_the_floor(&mut self, corner: Point, near: &Rung, rung: &Rung, bounds: &Bounds) {
        let line = self.link.highest();
        let left = Point::new(near.end, bounds.low(near.after[0]));
        let far = Point::new(rung.start.min(corner.z), corner.y);
        let exit = if line.at(far.z) >= far.y {
            meeting(&line, far, corner)
        } else {
            meeting(&line, left, far)
        };
        let touch = self.link.cross_highest(exit);
        self.follow(Window { line, from: touch.map_or(exit.z, |touch| touch.z), to: exit.z });
    }

    /// Adds the corner where the link along `next` starts.
    fn follow(&mut self, next: Window) {
        let corner = match (self.window, self.start) {
            (Some(last), _) => {
                let z = intersection(&last, &next.line);
                Point::new(z, next.line.at(z))
            }
            (None, Some(Start::Plateau([from, to]))) => {
                Point::new(reached(&next.line, 1.0, from, to), 1.0)
            }
            (None, Some(Start::Step { z, low, high })) => {
                Point::new(z, next.line.at(z).max(low).min(high))
            }
            (None, None) => return,
        };
        self.path.push(corner);
        self.window = Some(next);
    }

    /// Ends a stretch at the near side of a step.
    fn reach_step(&mut self, near: &Rung, rung: &Rung, bounds: &Bounds) {
        let (z, low, high) = (rung.start, bounds.low(rung.before[0]), bounds.high(rung.before[0]));
        self.pass_below(Point::new(z, high), near, rung, bounds);
        self.pass_above(Point::new(z, low), near, rung, bounds);
        let is_clear = self.window.is_none() && self.link.has_no_ceiling();
        if is_clear && matches!(self.start, Some(Start::Plateau(_))) {
            self.path.push(Point::new(z, 1.0));
            return;
        }
        let line = self.link.middle(z);
        self.follow(Window { line, from: z, to: z });
        self.path.push(Point::new(z, line.at(z).max(low).min(high)));
    }

    /// Ends the path on the plateau of the last value, at `z` at the latest.
    fn reach_end(&mut self, z: f64, bounds: &Bounds) {
        let line = self.link.middle(z);
        self.follow(Window { line, from: z, to: z });
        let from = self.path.last().map_or(z, |last| last.z);
        self.path.push(Point::new(reached(&line, bounds.last, from, z), bounds.last));
    }
}

/// The depth between two places at which the line through them has this value.
fn crossing(near: Point, far: Point, value: f64) -> f64 {
    let share = (near.y - value) / (near.y - far.y);
    if share > 0.0 { (near.z + (far.z - near.z) * share).min(far.z) } else { near.z }
}

/// The place where `line` meets the straight line from `near` to `far`, between which
/// it passes to the other side.
fn meeting(line: &Line, near: Point, far: Point) -> Point {
    let (from, to) = (near.y - line.at(near.z), far.y - line.at(far.z));
    let share = from / (from - to);
    let share = if share > 0.0 { share.min(1.0) } else { 0.0 };
    let z = near.z + (far.z - near.z) * share;
    Point::new(z, line.at(z))
}

/// The depth in the window at which `next` crosses it.
fn intersection(window: &Window, next: &Line) -> f64 {
    let line = window.line;
    let apart = line.at(window.to) - next.at(window.to);
    let by = apart / (line.slope() - next.slope());
    let z = window.to - by;
    if z >= window.from && z <= window.to {
        z
    } else if z < window.from {
        window.from
    } else {
        window.to
    }
}

/// The depth at which `line` has this value, within these bounds.
fn reached(line: &Line, value: f64, from: f64, to: f64) -> f64 {
    let (through, slope) = (line.through(), line.slope());
    let z = through.z + (value - through.y) / slope;
    if z >= to {
        to
    } else if z >= from {
        z
    } else if slope < 0.0 {
        from
    } else {
        to
    }
}
