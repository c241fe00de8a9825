//! A visibility function as a corridor: what a path through it must not leave.

use super::hull::Point;

/// The corridor's extent around one value of V, and its ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    /// Extent below V; negative where paths keep above V.
    pub(super) below: f64,
    /// Extent above V; negative where paths keep below V.
    pub(super) above: f64,
    /// The value that the path ends with.
    pub(super) last: f64,
}

impl Bounds {
    /// The least value of a path where V is `value`.
    #[inline(always)]
    pub(super) fn low(&self, value: f64) -> f64 {
        if value <= self.last { self.last } else { (value - self.below).clamp(self.last, 1.0) }
    }

    /// The largest value of a path where V is `value`.
    #[inline(always)]
    pub(super) fn high(&self, value: f64) -> f64 {
        if value >= 1.0 { 1.0 } else { (value + self.above).clamp(self.last, 1.0) }
    }
}

/// A stretch of depths in which V falls from `before` to `after`: a vertex, a step,
/// or a run of so little falls that they stand for one. V is linear between two.
///
/// Paths that never rise, keep below high(`after`) at the start and above low(`before`)
/// at the end keep within the corridor all along it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rung<S> {
    pub(super) start: f64,
    pub(super) end: f64,
    pub(super) before: S,
    pub(super) after: S,
}

impl<S: AsRef<[f64]>> Rung<S> {
    /// Where a channel of V leaves this rung.
    #[inline(always)]
    pub(super) fn near(&self, channel: usize) -> Point {
        Point::new(self.end, self.after.as_ref()[channel])
    }

    /// Where a channel of V reaches this rung.
    #[inline(always)]
    pub(super) fn far(&self, channel: usize) -> Point {
        Point::new(self.start, self.before.as_ref()[channel])
    }
}

/// Where a function ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct End<S> {
    /// What it ends with.
    pub(super) last: S,
    /// It has ended where it is not above this.
    pub(super) reached: S,
}

/// Replaces `rungs` by those of V, whose vertices have these depths and values, from the
/// last vertex of value 1 on to the first that has ended. Runs that fall by up to
/// `joined` are one rung each. O(n).
pub(super) fn fill<S: Copy + AsRef<[f64]> + AsMut<[f64]>>(
    rungs: &mut Vec<Rung<S>>,
    count: usize,
    depth: impl Fn(usize) -> f32,
    value: impl Fn(usize) -> S,
    end: &End<S>,
    joined: f64,
) {
    rungs.clear();
    let below = |value: &S, than: &S| {
        let mut both = value.as_ref().iter().zip(than.as_ref());
        both.all(|(value, than)| value <= than)
    };
    let is_clear = |value: S| value.as_ref().iter().all(|&value| value >= 1.0);
    // Both are near the ends, as a rule.
    let first = (0..count).find(|&index| !is_clear(value(index)));
    let last = (0..count).rev().take_while(|&index| below(&value(index), &end.reached)).last();
    let (Some(first), Some(last)) = (first.filter(|&first| first > 0), last) else { return };
    // Sums may be off in their last bits: V neither rises nor falls below its end.
    let settled = |index: usize, highest: &S| {
        let mut value = value(index);
        let limits = highest.as_ref().iter().zip(end.last.as_ref());
        for (value, (&highest, &last)) in value.as_mut().iter_mut().zip(limits) {
            let raised = if *value > last { *value } else { last };
            *value = if raised < highest { raised } else { highest };
        }
        value
    };
    // The last of the vertices that share a depth with one, and the next behind it.
    let group = |index: usize| {
        let next = index + 1;
        let is_step = next <= last && depth(next) <= depth(index);
        if is_step { (next, next + 1) } else { (index, next) }
    };
    let mut before = value(first - 1);
    before.as_mut().iter_mut().for_each(|value| *value = 1.0);
    let z = f64::from(depth(first - 1));
    let (at, mut index) = group(first - 1);
    let mut after = if index > last { end.last } else { settled(at, &before) };
    rungs.push(Rung { start: z, end: z, before, after });
    // The depth where the function ends stays alone.
    let is_step_at_end = last > 0 && depth(last - 1) >= depth(last);
    let last_group = if is_step_at_end { last - 1 } else { last };
    while index < last_group {
        let start = depth(index);
        let before = settled(index, &after);
        let (at, mut next) = group(index);
        after = settled(at, &before);
        let mut end = start;
        while next < last_group {
            let (at, behind) = group(next);
            let further = value(at);
            let mut falls = before.as_ref().iter().zip(further.as_ref());
            if falls.any(|(before, further)| before - further > joined) {
                break;
            }
            (end, after) = (depth(next), settled(at, &after));
            next = behind;
        }
        rungs.push(Rung { start: f64::from(start), end: f64::from(end), before, after });
        index = next;
    }
    if index <= last {
        let z = f64::from(depth(index));
        let before = if index < last { settled(index, &after) } else { end.last };
        rungs.push(Rung { start: z, end: z, before, after: end.last });
    }
}
