//! The compressor to fewest vertices.

use super::joint::JointWalk;
use super::rounding::Rounding;
use super::rungs::{self, Bounds, End, Rung};
use super::shorten::shorten;
use super::walk::Walk;
use crate::compress::compressor::Compressor;
use crate::compress::extent::Extent;
use crate::compress::greedy::{self, GreedyCompressor};
use crate::compress::side::Side;
use crate::tolerance::Tolerance;
use crate::transmittance::Transmittance;
use crate::visibility::vertex::{SumVertex, Vertex};

/// The share of ε that a run of falls may have that are passed as one: it costs about
/// two vertices in a hundred, and hair is several times faster.
const JOINED: f64 = 1.0 / 8.0;

/// The number of vertices up to which none are passed as one.
const EXACT_UP_TO: usize = 128;

/// What rounding a value to `f32` may move it by, and a lookup again.
const VALUE_ROUNDING: f64 = 1.0 / (1 << 25) as f64;

/// What a path keeps from V on a side where it must not pass it.
const CLEARANCE: f64 = 1.0 / (1_u64 << 36) as f64;

/// How far sums may be off in their last bits.
const SUM_ROUNDING: f64 = 1.0 / (1_u64 << 40) as f64;

/// Number of tubes that are tried, each narrower than the last.
const ATTEMPTS: usize = 4;

/// A compressor to the fewest vertices that a visibility function within ε of V can
/// have: a minimum-link path (Suri 1986) through the corridor V ± ε.
///
/// For every V that satisfies the invariant of
/// [`VisibilityView`](crate::visibility::function::VisibilityView), but for sums that
/// are off by up to 2⁻⁴⁰:
///
/// - |V′ − V| ≤ ε at both sides of every vertex, in every channel, with `f32` values, of
///   which 2⁻²⁴ are left for rounding at a lookup: measured in `f64` on what is stored,
///   and drawn again in a narrower tube if it doesn't hold;
/// - V′ satisfies the invariant as well, is 1 before V first falls and ends with V(∞)
///   rounded to `f32`, at the depth where V does at the latest;
/// - no polyline with vertical steps that does all that in a tube narrower than ε by a
///   128th has fewer vertices, if V has at most 128 and one channel. With more, runs of
///   falls up to ε/8 are passed as one, which costs about 2 % vertices; several
///   channels share their depths, which are depths of V, and have few vertices, not the
///   fewest.
///
/// With a [`Side`] other than both, V′ keeps on that side of V, rounding and the last
/// value included.
///
/// O(n) amortised; four to ten times the time of a greedy pass. Keeps its memory
/// from one function to the next.
///
/// ```
/// use dsm_core::{Side, Tolerance, Vertex};
/// use dsm_core::detail::{Compressor, MinLinkCompressor};
///
/// // Ten sheets that each stop a twentieth of the light.
/// let left = |sheets: u8| [f64::from(20 - sheets) / 20.0];
/// let steps = (1..=10_u8).flat_map(|sheet| {
///     [left(sheet - 1), left(sheet)].map(|value| Vertex::new(f32::from(sheet), value))
/// });
/// let exact: Vec<_> = steps.collect();
/// let mut compressed: Vec<Vertex<f32>> = Vec::new();
/// let mut compressor = MinLinkCompressor::new(Side::Both);
/// compressor.compress(Tolerance::new(0.06)?, &exact, &mut |vertex| compressed.push(vertex));
/// assert_eq!(compressed.len(), 2);
/// assert_eq!([compressed[0].value, compressed[1].value], [1.0, 0.5]);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct MinLinkCompressor<T: Transmittance> {
    /// The shares of ε below and above V.
    shares: [f64; 2],
    side: Side,
    walk: Walk,
    rungs: Vec<Rung<[f64; 1]>>,
    joint: JointWalk<T>,
    joint_rungs: Vec<Rung<T::Sum>>,
    stored: Vec<Vertex<T>>,
}

impl<T: Transmittance> MinLinkCompressor<T> {
    /// A compressor that keeps to this side of V.
    #[must_use]
    pub fn new(side: Side) -> Self {
        Self::with_shares(side, side.shares())
    }

    /// A compressor into [V − `below` ε, V + `above` ε], both in (0, 1]: with less
    /// below than above, less of what V falls by shadows itself.
    #[must_use]
    pub fn asymmetric(below: f32, above: f32) -> Self {
        let shares = [below, above].map(|share| f64::from(share.clamp(1.0 / 1024.0, 1.0)));
        Self::with_shares(Side::Both, shares)
    }

    fn with_shares(side: Side, shares: [f64; 2]) -> Self {
        Self {
            shares,
            side,
            walk: Walk::default(),
            rungs: Vec::new(),
            joint: JointWalk::default(),
            joint_rungs: Vec::new(),
            stored: Vec::new(),
        }
    }

    /// Draws V′ into `self.stored`; false if it is not within the tolerance.
    fn draw(&mut self, epsilon: f64, vertices: &[SumVertex<T>]) -> bool {
        self.stored.clear();
        let Some(end) = vertices.last().map(|last| last.value) else { return true };
        let last = T::from_channels(|channel| self.side.round(end.as_ref()[channel].max(0.0)));
        if last == T::CLEAR {
            return self.is_kept(epsilon, vertices).is_none();
        }
        let is_mono = T::CHANNELS == 1
            || vertices.iter().all(|vertex| {
                let value = vertex.value.as_ref();
                value.iter().all(|channel| *channel == value[0])
            });
        let rounding = Rounding::new(self.side, epsilon);
        let mut spent = 2.0 * VALUE_ROUNDING + SUM_ROUNDING + rounding.spent();
        for _ in 0..ATTEMPTS {
            let [below, above] = self
                .shares
                .map(|share| if share > 0.0 { epsilon * share - spent } else { -CLEARANCE });
            if below + above <= 0.0 {
                return false;
            }
            let bounds =
                |channel: usize| Bounds { below, above, last: f64::from(last.channel(channel)) };
            let joined =
                if vertices.len() > EXACT_UP_TO { JOINED * 0.5 * (below + above) } else { 0.0 };
            if is_mono {
                self.draw_one(&bounds(0), end.as_ref()[0], joined, &rounding, vertices);
            } else {
                self.draw_joint(&[0, 1, 2].map(bounds), end, joined, &rounding, vertices);
            }
            let Some(excess) = self.is_kept(epsilon, vertices) else { return true };
            spent = 2.0 * spent + 4.0 * excess;
        }
        false
    }

    /// What V has to fall to so that V′ may have its last value.
    fn reached(&self, end: f64, last: f64) -> f64 {
        if self.side == Side::Lighter { last } else { end.max(last) + SUM_ROUNDING }
    }

    fn draw_one(
        &mut self,
        bounds: &Bounds,
        end: f64,
        joined: f64,
        rounding: &Rounding,
        vertices: &[SumVertex<T>],
    ) {
        let end = End { last: [bounds.last], reached: [self.reached(end, bounds.last)] };
        let depth = |index: usize| vertices[index].z;
        let value = |index: usize| [vertices[index].value.as_ref()[0]];
        rungs::fill(&mut self.rungs, vertices.len(), depth, value, &end, joined);
        let path = self.walk.run(&self.rungs, bounds);
        if let [first, .., last] = self.rungs.as_slice() {
            rounding.move_depths(path, [first.start, last.end]);
            shorten(path, &self.rungs, bounds);
        }
        rounding.store(path, &mut self.stored);
    }

    fn draw_joint(
        &mut self,
        bounds: &[Bounds; 3],
        end: T::Sum,
        joined: f64,
        rounding: &Rounding,
        vertices: &[SumVertex<T>],
    ) {
        let last = T::sum_from_channels(|channel| bounds[channel].last);
        let reached = T::sum_from_channels(|channel| {
            self.reached(end.as_ref()[channel], bounds[channel].last)
        });
        let end = End { last, reached };
        let depth = |index: usize| vertices[index].z;
        let value = |index: usize| vertices[index].value;
        rungs::fill(&mut self.joint_rungs, vertices.len(), depth, value, &end, joined);
        let path = self.joint.run(&self.joint_rungs, bounds);
        let mut highest = T::CLEAR;
        self.stored.clear();
        for corner in path {
            // Depths of V need no rounding.
            highest = T::from_channels(|channel| {
                let exact = corner.value.as_ref()[channel];
                let last = bounds[channel].last as f32;
                // Ends stay as they are.
                let is_end = exact >= 1.0 || exact <= bounds[channel].last;
                let value = if is_end { exact as f32 } else { rounding.value(exact) };
                value.max(last).min(highest.channel(channel))
            });
            self.stored.push(Vertex::new(corner.z, highest));
        }
    }

    /// How far what is stored leaves the tolerance, if it does.
    fn is_kept(&self, epsilon: f64, vertices: &[SumVertex<T>]) -> Option<f64> {
        let extent = Extent::of(vertices, &self.stored);
        let [below, above] = self
            .shares
            .map(|share| if share > 0.0 { epsilon * share - 2.0 * VALUE_ROUNDING } else { 0.0 });
        let excess = (extent.below - below).max(extent.above - above);
        (excess > 0.0).then_some(excess)
    }

    /// Copies V onto its side, so that it needs no tolerance but for rounding.
    fn copy(&mut self, vertices: &[SumVertex<T>]) {
        self.stored.clear();
        let mut limit = if self.side == Side::Lighter { T::BLOCKED } else { T::CLEAR };
        let mut copy = |vertex: &SumVertex<T>| {
            limit = T::from_channels(|channel| {
                let value = self.side.round(vertex.value.as_ref()[channel]).clamp(0.0, 1.0);
                let limit = limit.channel(channel);
                if self.side == Side::Lighter { value.max(limit) } else { value.min(limit) }
            });
            Vertex::new(vertex.z, limit)
        };
        // What may rise in its last bits is followed from the side that it keeps to.
        if self.side == Side::Lighter {
            self.stored.extend(vertices.iter().rev().map(&mut copy));
            self.stored.reverse();
        } else {
            self.stored.extend(vertices.iter().map(&mut copy));
        }
        // V' starts where it leaves 1.
        let first = self.stored.iter().position(|vertex| vertex.value != T::CLEAR);
        self.stored.drain(..first.unwrap_or(self.stored.len()).saturating_sub(1));
        if first.is_none() {
            self.stored.clear();
        }
    }
}

impl<T: Transmittance> Compressor<T> for MinLinkCompressor<T> {
    fn compress(
        &mut self,
        tolerance: Tolerance,
        vertices: &[SumVertex<T>],
        emit: &mut impl FnMut(Vertex<T>),
    ) {
        let is_drawn = tolerance.epsilon() >= GreedyCompressor::<T>::COPY_BELOW
            && self.draw(f64::from(tolerance.epsilon()), vertices);
        if !is_drawn && self.shares == Side::Both.shares() {
            greedy::compress_all(tolerance, vertices, emit);
            return;
        }
        if !is_drawn {
            self.copy(vertices);
        }
        self.stored.iter().for_each(|&vertex| emit(vertex));
    }
}
