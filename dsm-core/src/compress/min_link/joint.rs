//! A path of few links through the corridors of several channels, whose corners share
//! their depths.

use super::hull::Point;
use super::link::Link;
use super::rungs::{Bounds, Rung};
use crate::transmittance::Transmittance;
use crate::visibility::vertex::{SumVertex, Vertex};

/// The share of the tolerance that every channel should have to choose from where a
/// link ends.
const ROOM: f64 = 0.5;

/// Values that paths can have at a rung, in every channel.
#[derive(Clone, Copy, Debug)]
struct Reach<T: Transmittance> {
    z: f64,
    low: T::Sum,
    high: T::Sum,
    /// The rung that it lies at.
    rung: usize,
    /// A step from the station before, which lies at the same depth.
    is_step: bool,
}

impl<T: Transmittance> Reach<T> {
    /// Has a channel reach what a link does within these limits.
    fn set(&mut self, channel: usize, [least, most]: [f64; 2], [low, high]: [f64; 2]) {
        let low = least.max(low);
        self.low.as_mut()[channel] = low;
        self.high.as_mut()[channel] = most.min(high).max(low);
    }
}

/// Finds the corners of a monotone path whose channels share their depths: each link
/// goes as far as any can in all of them, and ends at the last depth of V where every
/// channel has some values to choose from.
///
/// Few links, not the fewest: that takes corners anywhere. O(n).
#[derive(Clone, Debug)]
pub(super) struct JointWalk<T: Transmittance> {
    links: Vec<Link>,
    /// Where links start and end.
    stations: Vec<Reach<T>>,
    /// What the link can be at the rungs since its start.
    passed: Vec<Reach<T>>,
    path: Vec<SumVertex<T>>,
}

impl<T: Transmittance> Default for JointWalk<T> {
    fn default() -> Self {
        Self {
            links: vec![Link::default(); T::CHANNELS],
            stations: Vec::new(),
            passed: Vec::new(),
            path: Vec::new(),
        }
    }
}

impl<T: Transmittance> JointWalk<T> {
    /// The corners of the path through the corridors of `rungs`, one for every channel.
    pub(super) fn run(&mut self, rungs: &[Rung<T::Sum>], bounds: &[Bounds]) -> &[SumVertex<T>] {
        self.path.clear();
        self.stations.clear();
        let Some(first) = rungs.first() else { return &self.path };
        let clear = T::CLEAR.to_sum();
        let start = Reach { z: first.start, low: clear, high: clear, rung: 0, is_step: false };
        self.stations.push(start);
        let corridor = Corridor { rungs, bounds };
        let is_within = |channel: usize| corridor.high(0, channel) >= 1.0;
        if !(0..T::CHANNELS).all(is_within) {
            self.step(&corridor, start);
        }
        let mut next = 1;
        self.restart(&corridor);
        while next < rungs.len() {
            if self.pass(&corridor, next) {
                next += 1;
                continue;
            }
            next = self.turn(&corridor, next);
        }
        if let Some(end) = self.passed.pop() {
            self.stations.push(end);
        }
        self.choose(&corridor);
        &self.path
    }

    /// Starts links at the last station.
    fn restart(&mut self, corridor: &Corridor<'_, T>) {
        self.passed.clear();
        let Some(&station) = self.stations.last() else { return };
        for (channel, link) in self.links.iter_mut().enumerate() {
            let place = |values: &T::Sum| Point::new(station.z, values.as_ref()[channel]);
            link.start_at_step(place(&station.low), place(&station.high));
        }
        // Behind a step at the start of a run its end is still to be passed.
        let end = corridor.rungs[station.rung].end;
        if station.is_step && end > station.z {
            let mut reach = Reach { z: end, is_step: false, ..station };
            for (channel, link) in self.links.iter_mut().enumerate() {
                let low = station.low.as_ref()[channel];
                link.pass_above(Point::new(end, low));
                reach.set(channel, link.range(end), [low, station.high.as_ref()[channel]]);
            }
            self.passed.push(reach);
        }
    }

    /// Passes a rung in every channel; false if that takes another link.
    fn pass(&mut self, corridor: &Corridor<'_, T>, rung: usize) -> bool {
        let Some(from) = self.stations.last() else { return false };
        let Rung { start, end, .. } = corridor.rungs[rung];
        let mut reach: Reach<T> =
            Reach { z: end, low: from.low, high: from.high, rung, is_step: false };
        for (channel, link) in self.links.iter_mut().enumerate() {
            let (low, high) = (corridor.low(rung, channel), corridor.high(rung, channel));
            if low > high
                || !link.pass_below(Point::new(start, high))
                || !link.pass_above(Point::new(end, low))
            {
                return false;
            }
            reach.set(channel, link.range(end), [low, high.min(from.high.as_ref()[channel])]);
        }
        self.passed.push(reach);
        true
    }

    /// Ends the link that does not pass `rung`; returns the rung to go on with.
    fn turn(&mut self, corridor: &Corridor<'_, T>, rung: usize) -> usize {
        // Not before the middle, so that no rung is passed more than twice or so.
        let kept = self.passed.len() / 2;
        let highest = self.stations.last().map_or(T::CLEAR.to_sum(), |from| from.high);
        let room = |reach: &Reach<T>| {
            let widths = (0..T::CHANNELS).map(|channel| {
                let [low, high] = [reach.low, reach.high].map(|value| value.as_ref()[channel]);
                let bounds = &corridor.bounds[channel];
                // Not more than there is to choose from for any link.
                let most = corridor.high(reach.rung, channel).min(highest.as_ref()[channel])
                    - corridor.low(reach.rung, channel);
                let wanted = (ROOM * 0.5 * (bounds.below + bounds.above)).min(most);
                if wanted > 0.0 { (high - low) / wanted } else { 1.0 }
            });
            widths.fold(f64::INFINITY, f64::min)
        };
        let late = self.passed.iter().enumerate().skip(kept).rev();
        let mut best: Option<(usize, f64)> = None;
        for (index, reach) in late {
            let room = room(reach);
            if best.is_none_or(|(_, most)| room > most) {
                best = Some((index, room));
            }
            if room >= 1.0 {
                break;
            }
        }
        if let Some((index, _)) = best {
            let station = self.passed[index];
            self.stations.push(station);
            self.restart(corridor);
            return station.rung + 1;
        }
        // Not even the next rung: a step there. Its near side is reached along V.
        let Some(from) = self.stations.last().copied() else { return rung };
        self.restart(corridor);
        let start = corridor.rungs[rung].start;
        let mut near: Reach<T> = Reach { z: start, rung, ..from };
        for (channel, link) in self.links.iter_mut().enumerate() {
            let value = corridor.rungs[rung].before.as_ref()[channel];
            let bounds = &corridor.bounds[channel];
            let (low, high) = (bounds.low(value), bounds.high(value));
            link.pass_below(Point::new(start, high));
            link.pass_above(Point::new(start, low));
            near.set(channel, link.range(start), [low, high.min(from.high.as_ref()[channel])]);
        }
        near.is_step = false;
        self.stations.push(near);
        self.step(corridor, near);
        self.restart(corridor);
        rung + 1
    }

    /// Steps down at a rung from what is reached on its near side.
    fn step(&mut self, corridor: &Corridor<'_, T>, near: Reach<T>) {
        let rung = near.rung;
        let limit = |channel: usize| near.high.as_ref()[channel];
        let low = T::sum_from_channels(|channel| {
            let bounds = &corridor.bounds[channel];
            let Rung { start, end, before, after } = &corridor.rungs[rung];
            let value = if end > start { before } else { after }.as_ref()[channel];
            bounds.low(value).min(limit(channel))
        });
        let high = T::sum_from_channels(|channel| {
            corridor.high(rung, channel).min(limit(channel)).max(low.as_ref()[channel])
        });
        self.stations.push(Reach { low, high, is_step: true, ..near });
    }

    /// Chooses values for the stations, last to first: as near to V as the links allow.
    fn choose(&mut self, corridor: &Corridor<'_, T>) {
        let mut next: Option<(Reach<T>, T::Sum)> = None;
        for station in self.stations.iter().rev() {
            let value = T::sum_from_channels(|channel| {
                let rung = &corridor.rungs[station.rung];
                let (mut low, mut high) =
                    (station.low.as_ref()[channel], station.high.as_ref()[channel]);
                let mut wanted = rung.after.as_ref()[channel];
                if let Some((next, value)) = &next {
                    let to = Point::new(next.z, value.as_ref()[channel]);
                    low = low.max(to.y);
                    if next.is_step {
                        wanted = rung.before.as_ref()[channel];
                    } else {
                        let among = station.rung..=next.rung;
                        let [least, most] = corridor.starts(channel, station.z, to, among);
                        (low, high) = (low.max(least), high.min(most));
                    }
                }
                wanted.min(high).max(low)
            });
            let corner = Vertex::new(station.z as f32, value);
            // A step that only some run needed room for.
            if self.path.last() != Some(&corner) {
                self.path.push(corner);
            }
            next = Some((*station, value));
        }
        self.path.reverse();
        // The plateaus at both ends start and end with the function.
        let clear = T::CLEAR.to_sum();
        let leaves = self.path.iter().position(|corner| corner.value != clear);
        self.path.drain(..leaves.unwrap_or(self.path.len()).saturating_sub(1));
        if let Some(last) = self.path.last().map(|last| last.value) {
            let settles = self.path.iter().position(|corner| corner.value == last);
            self.path.truncate(settles.map_or(0, |first| first + 1));
        }
    }
}

/// The corridors of all channels.
struct Corridor<'a, T: Transmittance> {
    rungs: &'a [Rung<T::Sum>],
    bounds: &'a [Bounds],
}

impl<T: Transmittance> Corridor<'_, T> {
    /// What a path must not be below at a rung's end.
    fn low(&self, rung: usize, channel: usize) -> f64 {
        let value = self.rungs[rung].before.as_ref()[channel];
        self.bounds[channel].low(value)
    }

    /// What a path must not be above at a rung's start: the end, at the last.
    fn high(&self, rung: usize, channel: usize) -> f64 {
        let bounds = &self.bounds[channel];
        if rung + 1 == self.rungs.len() {
            bounds.last
        } else {
            bounds.high(self.rungs[rung].after.as_ref()[channel])
        }
    }

    /// The values at `z` of lines to `to` that pass these rungs.
    fn starts(
        &self,
        channel: usize,
        z: f64,
        to: Point,
        rungs: std::ops::RangeInclusive<usize>,
    ) -> [f64; 2] {
        let (mut least, mut most) = (f64::NEG_INFINITY, f64::INFINITY);
        for rung in rungs {
            let Rung { start, end, .. } = self.rungs[rung];
            let value = |corner: f64, y: f64| {
                let stretch = (to.z - z) / (to.z - corner);
                if stretch.is_finite() { to.y + (y - to.y) * stretch } else { to.y }
            };
            if start > z && start < to.z {
                most = most.min(value(start, self.high(rung, channel)));
            }
            if end > z && end < to.z {
                least = least.max(value(end, self.low(rung, channel)));
            }
        }
        [least, most]
    }
}
