//! The weighted sum of many functions of depth in one pass (Lokovic & Veach
//! 2000, equation 1 and §5.1): of the transmittance functions of a pixel's
//! samples, or of the visibility functions of pixels (§5.3).

use super::compensated::RunningSum;
use super::depth_sort::sort_by_depth;
use super::exact_sum::ExactSum;
use super::steps::{End, FinalSum, draw_steps};
use super::transmittance_function::TransmittanceFunction;
use crate::transmittance::Transmittance;
use crate::visibility::function::VisibilityFunction;
use crate::visibility::polyline::Polyline;
use crate::visibility::vertex::{SumVertex, Vertex};
use crate::visibility::vertex_writer::VertexWriter;

/// The sweep that sums weighted transmittance functions, one pixel after the other;
/// keeps its memory in between. Pixels of coarser mip levels are sums of the same
/// kind, of visibility functions (§5.3).
///
/// The sum runs along z with its value and slope, which every vertex of every
/// function changes a little: O(n log n) for n vertices, as in §5.1 of
/// Lokovic & Veach 2000. Unlike there, no heap holds the next vertex of each
/// function: all are sorted once by depth, several times faster than n passes
/// through a heap. The value is a compensated sum and the slope an exact one,
/// so that neither drifts, however steep a ramp has ended.
///
/// ```
/// use dsm_core::detail::{TransmittanceFunction, VisibilitySweep};
/// use dsm_core::{RayHits, SurfaceHit, VisibilityFunction};
///
/// // An opaque blocker covers a quarter of the pixel: one ray of four.
/// let mut hits = RayHits::<f32>::default();
/// hits.push_surface(SurfaceHit { depth: 2.0, opacity: 1.0 })?;
/// let blocked = TransmittanceFunction::new(&hits, 0.01);
/// let clear = TransmittanceFunction::default();
/// let functions = [(0.25, &blocked), (0.25, &clear), (0.25, &clear), (0.25, &clear)];
///
/// let mut sweep = VisibilitySweep::default();
/// let pixel = sweep.over(&functions);
/// assert_eq!(pixel.final_value(), [0.75]);
/// let mut vertices = Vec::new();
/// pixel.run(|vertex| vertices.push((vertex.z, vertex.value[0])));
/// assert_eq!(vertices, [(2.0, 1.0), (2.0, 0.75)]);
///
/// // That pixel and three clear ones, averaged for the next mip level.
/// let fine = sweep.over(&functions).visibility_function();
/// let empty = VisibilityFunction::clear();
/// let pixels = [(0.25, &fine), (0.25, &empty), (0.25, &empty), (0.25, &empty)];
/// assert_eq!(sweep.average(&pixels).final_value(), [0.9375]);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct VisibilitySweep<T: Transmittance> {
    /// Depth bits above the index of what happens there, in `steps` and
    /// `slopes`.
    events: Vec<u64>,
    spare: Vec<u64>,
    steps: Vec<T::Sum>,
    /// The slopes that end and start; empty where all functions are
    /// staircases.
    slopes: Vec<SlopeChange<T>>,
    slope: Vec<ExactSum>,
}

#[derive(Clone, Copy, Debug)]
struct SlopeChange<T: Transmittance> {
    ends: T::Sum,
    starts: T::Sum,
}

impl<T: Transmittance> Default for VisibilitySweep<T> {
    fn default() -> Self {
        Self {
            events: Vec::new(),
            spare: Vec::new(),
            steps: Vec::new(),
            slopes: Vec::new(),
            slope: vec![ExactSum::default(); T::CHANNELS],
        }
    }
}

impl<T: Transmittance> VisibilitySweep<T> {
    /// The weighted sum Σ wₖ τₖ of `functions`. The weights must sum to 1 but
    /// for rounding; functions of weight 0 (or less, or NaN) do not count, and
    /// without any other the sum is 1 everywhere.
    pub fn over<'a>(
        &'a mut self,
        functions: &'a [(f64, &'a TransmittanceFunction<T>)],
    ) -> WeightedTransmittance<'a, T> {
        WeightedTransmittance::new(self, functions)
    }

    /// The weighted sum of visibility functions, stored or not yet compressed: the
    /// uncompressed function of a pixel of a coarser mip level (§5.3).
    pub fn average<'a, F: Polyline<Sum = T::Sum>>(
        &'a mut self,
        functions: &'a [(f64, F)],
    ) -> WeightedTransmittance<'a, T, F> {
        WeightedTransmittance::new(self, functions)
    }
}

/// A weighted sum of transmittance or visibility functions that is about to be
/// swept.
#[derive(Debug)]
pub struct WeightedTransmittance<'a, T: Transmittance, F = &'a TransmittanceFunction<T>> {
    sweep: &'a mut VisibilitySweep<T>,
    functions: &'a [(f64, F)],
    final_value: T::Sum,
    /// Depth, per channel, where the last function reaches its final value.
    settled: T::Sum,
    curved: bool,
}

impl<'a, T: Transmittance, F: Polyline<Sum = T::Sum>> WeightedTransmittance<'a, T, F> {
    fn new(sweep: &'a mut VisibilitySweep<T>, functions: &'a [(f64, F)]) -> Self {
        let mut sum = FinalSum::<T>::new();
        let mut settled = T::sum_from_channels(|_| f64::NEG_INFINITY);
        let mut curved = false;
        for (weight, function) in contributing(functions) {
            let last = last::<T>(function);
            for channel in 0..T::CHANNELS {
                sum.add(channel, weight, last.as_ref()[channel]);
                let settled = &mut settled.as_mut()[channel];
                *settled = settled.max(settled_at::<T>(function, channel));
            }
            curved |= function.has_ramps();
        }
        let final_value = alone(functions).map_or_else(|| sum.value(), last::<T>);
        Self { sweep, functions, final_value, settled, curved }
    }

    /// The final visibility, before the sweep: Σ wₖ τₖ(∞), exactly the value of the
    /// last vertex (1 if there will be none).
    #[must_use]
    pub const fn final_value(&self) -> T::Sum {
        self.final_value
    }

    /// True if a contributing function has ramps. Those of transmittance functions
    /// are chords, and the chord error was spent
    /// ([`TransmittanceFunction::is_curved`]).
    #[must_use]
    pub const fn is_curved(&self) -> bool {
        self.curved
    }

    /// Passes the vertices of the sum to `sink`, front to back.
    ///
    /// They start at exactly 1, are sorted by z with at most two at one z, lie
    /// in \[0, 1\] and never rise. A channel is exactly 0 from where all
    /// contributing functions are. A function alone, of weight 1, comes
    /// through unchanged.
    pub fn run(self, sink: impl FnMut(SumVertex<T>)) {
        if let Some(alone) = alone(self.functions) {
            vertices(alone).for_each(sink);
        } else if self.curved {
            self.sweep_ramps(sink);
        } else {
            self.sweep_steps(sink);
        }
    }

    /// The sum as a function of its own, uncompressed and rounded to `f32`.
    #[must_use]
    pub fn visibility_function(self) -> VisibilityFunction<T> {
        let mut vertices: Vec<Vertex<T>> = Vec::new();
        self.run(|vertex| {
            let rounded = Vertex::new(vertex.z, T::from_sum(vertex.value));
            if vertices.last() != Some(&rounded) {
                vertices.push(rounded);
            }
        });
        VisibilityFunction::unchecked(&vertices)
    }

    /// The sweep where no function has a slope.
    fn sweep_steps(self, sink: impl FnMut(SumVertex<T>)) {
        let Self { sweep: VisibilitySweep { events, spare, steps, .. }, functions, .. } = self;
        events.clear();
        steps.clear();
        for (weight, function) in contributing(functions) {
            for step in (0..function.vertex_count()).step_by(2) {
                let [before, after] = [step, step + 1].map(|vertex| function.sum_vertex(vertex));
                events.push(event(before.z, steps.len()));
                steps.push(difference::<T>(weight, before.value, after.value));
            }
        }
        sort_by_depth(events, spare);

        let end = End::<T> { value: self.final_value, settled: self.settled };
        let step = |&event: &u64| ((event >> 32) as u32, steps[event as u32 as usize]);
        draw_steps(events.iter().map(step), &end, sink);
    }

    /// The sweep where some functions have ramps.
    fn sweep_ramps(self, sink: impl FnMut(SumVertex<T>)) {
        self.sweep.gather_ramps(self.functions);
        let VisibilitySweep { events, spare, steps, slopes, slope } = self.sweep;
        sort_by_depth(events, spare);

        let mut writer = VertexWriter::<T, _>::new(sink);
        let mut value = RunningSum::<T>::new(1.0);
        let mut here = 0.0;
        for group in events.chunk_by(|a, b| a >> 32 == b >> 32) {
            let z = f32::from_bits((group[0] >> 32) as u32);
            let length = f64::from(z) - here;
            here = f64::from(z);
            for (channel, slope) in slope.iter().enumerate() {
                if !slope.is_empty() {
                    value.add(channel, slope.value().0 * length);
                }
            }
            let before = value.value();
            let mut stepped = T::sum_from_channels(|_| 0.0);
            for &event in group {
                let index = event as u32 as usize;
                let (step, change) = (&steps[index], &slopes[index]);
                for (channel, slope) in slope.iter_mut().enumerate() {
                    let height = step.as_ref()[channel];
                    if height != 0.0 {
                        value.add(channel, height);
                        stepped.as_mut()[channel] = 1.0;
                    }
                    for term in [-change.ends.as_ref()[channel], change.starts.as_ref()[channel]] {
                        if term != 0.0 {
                            slope.add(term);
                        }
                    }
                }
            }
            let settle = |channel: usize, value: f64| {
                let last = self.final_value.as_ref()[channel];
                if here >= self.settled.as_ref()[channel] { last } else { value.max(last) }
            };
            // Where a ramp ends at the final value, rounding must not leave a
            // step.
            let before = T::sum_from_channels(|channel| {
                let (last, value) = (self.final_value.as_ref()[channel], before.as_ref()[channel]);
                if stepped.as_ref()[channel] == 0.0 {
                    settle(channel, value)
                } else {
                    value.max(last)
                }
            });
            writer.line_to(z, before);
            writer.line_to(
                z,
                T::sum_from_channels(|channel| {
                    if stepped.as_ref()[channel] == 0.0 {
                        before.as_ref()[channel]
                    } else {
                        settle(channel, value.channel(channel))
                    }
                }),
            );
        }
    }
}

impl<T: Transmittance> VisibilitySweep<T> {
    /// Lists the steps and slopes of all functions.
    fn gather_ramps<F: Polyline<Sum = T::Sum>>(&mut self, functions: &[(f64, F)]) {
        self.events.clear();
        self.steps.clear();
        self.slopes.clear();
        self.slope.iter_mut().for_each(ExactSum::clear);
        for (weight, function) in contributing(functions) {
            let mut ends = T::sum_from_channels(|_| 0.0);
            let mut vertices = vertices(function).peekable();
            while let Some(before) = vertices.next() {
                let after = vertices.next_if(|vertex| vertex.z == before.z).unwrap_or(before);
                let starts = vertices.peek().map_or(T::sum_from_channels(|_| 0.0), |next| {
                    let length = f64::from(next.z) - f64::from(after.z);
                    let fall = difference::<T>(weight, after.value, next.value);
                    T::sum_from_channels(|channel| fall.as_ref()[channel] / length)
                });
                self.events.push(event(before.z, self.steps.len()));
                self.steps.push(difference::<T>(weight, before.value, after.value));
                self.slopes.push(SlopeChange { ends, starts });
                ends = starts;
            }
        }
    }
}

/// The functions that count, with their weights.
fn contributing<F>(functions: &[(f64, F)]) -> impl Iterator<Item = (f64, &F)> {
    functions
        .iter()
        .map(|(weight, function)| (*weight, function))
        .filter(|&(weight, _)| weight > 0.0)
}

/// The only function that counts, if it stands for itself.
fn alone<F>(functions: &[(f64, F)]) -> Option<&F> {
    let mut functions = contributing(functions);
    match (functions.next(), functions.next()) {
        (Some((1.0, alone)), None) => Some(alone),
        _ => None,
    }
}

fn vertices<F: Polyline>(function: &F) -> impl Iterator<Item = Vertex<F::Sum>> {
    (0..function.vertex_count()).map(|vertex| function.sum_vertex(vertex))
}

/// The final value of `function`.
fn last<T: Transmittance>(function: &impl Polyline<Sum = T::Sum>) -> T::Sum {
    let last = function.vertex_count().checked_sub(1);
    last.map_or(T::CLEAR.to_sum(), |last| function.sum_vertex(last).value)
}

/// A sort key: fewer than 2³² vertices come together.
fn event(z: f32, index: usize) -> u64 {
    // A stored depth may be −0, whose bits sort behind all others.
    u64::from((z + 0.0).to_bits()) << 32 | u64::from(index as u32)
}

/// weight · (to − from), channel by channel.
fn difference<T: Transmittance>(weight: f64, from: T::Sum, to: T::Sum) -> T::Sum {
    T::sum_from_channels(|channel| weight * (to.as_ref()[channel] - from.as_ref()[channel]))
}

/// The depth from which on `channel` of `function` keeps its final value.
fn settled_at<T: Transmittance>(function: &impl Polyline<Sum = T::Sum>, channel: usize) -> f64 {
    let value = |vertex: usize| function.sum_vertex(vertex).value.as_ref()[channel];
    let depth = |vertex: usize| f64::from(function.sum_vertex(vertex).z);
    let Some(last) = function.vertex_count().checked_sub(1).filter(|&last| last > 0) else {
        return f64::NEG_INFINITY;
    };
    let final_value = value(last);
    if value(last - 1) > final_value {
        return depth(last);
    }
    // The first vertex that is not above the final value.
    let (mut above, mut first) = (0, last);
    while above < first {
        let middle = (above + first) / 2;
        if value(middle) > final_value { above = middle + 1 } else { first = middle }
    }
    depth(first)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hits::hit::{RayHits, SurfaceHit};

    fn surface(depth: f32, opacity: f32) -> TransmittanceFunction<f32> {
        let mut hits = RayHits::default();
        hits.push_surface(SurfaceHit { depth, opacity }).unwrap();
        TransmittanceFunction::new(&hits, 0.01)
    }

    fn slab(near: f32, far: f32, opacity: f32) -> TransmittanceFunction<f32> {
        let mut hits = RayHits::default();
        hits.push_slab(near, far, opacity).unwrap();
        // One chord: the middle of the slab is a straight ramp.
        TransmittanceFunction::new(&hits, 0.9)
    }

    fn swept(functions: &[(f64, &TransmittanceFunction<f32>)]) -> Vec<(f32, f64)> {
        let mut sweep = VisibilitySweep::default();
        let sum = sweep.over(functions);
        let last = sum.final_value()[0];
        let mut vertices = Vec::new();
        sum.run(|vertex| vertices.push((vertex.z, vertex.value[0])));
        assert_eq!(vertices.last().map_or(1.0, |&(_, value)| value), last);
        vertices
    }

    #[test]
    fn steps_at_one_depth_are_one_step() {
        let (a, b, c) = (surface(2.0, 0.5), surface(2.0, 1.0), surface(1.0, 0.5));
        assert_eq!(
            swept(&[(0.25, &a), (0.25, &b), (0.5, &c)]),
            [(1.0, 1.0), (1.0, 0.75), (2.0, 0.75), (2.0, 0.375)]
        );
    }

    #[test]
    fn ramps_and_steps_add() {
        let (step, ramp) = (surface(2.0, 1.0), slab(1.0, 3.0, 0.5));
        assert_eq!(
            swept(&[(0.5, &step), (0.5, &ramp)]),
            [(1.0, 1.0), (2.0, 0.875), (2.0, 0.375), (3.0, 0.25)]
        );
    }

    #[test]
    fn one_function_passes_unchanged() {
        let ramp = slab(1.0, 3.0, 0.3);
        let alone: Vec<_> =
            ramp.vertices().iter().map(|vertex| (vertex.z, vertex.value[0])).collect();
        assert_eq!(swept(&[(0.0, &surface(1.0, 1.0)), (1.0, &ramp)]), alone);
    }

    #[test]
    fn all_blocked_is_exactly_zero() {
        let blocked: Vec<_> = (0..10_u8).map(|z| surface(f32::from(z), 1.0)).collect();
        let functions: Vec<_> = blocked.iter().map(|function| (0.1, function)).collect();
        assert_eq!(swept(&functions).last(), Some(&(9.0, 0.0)));
    }

    #[test]
    fn nothing_contributing_is_clear() {
        assert_eq!(swept(&[]), []);
        assert_eq!(swept(&[(0.0, &surface(1.0, 1.0)), (f64::NAN, &surface(1.0, 1.0))]), []);
    }

    #[test]
    fn rounding_to_f32_leaves_no_empty_step() {
        let (faint, half) = (surface(1.0, 2.0_f32.powi(-24)), surface(2.0, 0.5));
        let functions = [(0.125, &faint), (0.875, &half)];
        let function = VisibilitySweep::default().over(&functions).visibility_function();
        assert_eq!(function.view().depths(), [1.0, 2.0, 2.0]);
        assert_eq!(function.view().columns(), [1.0, 1.0, 0.5625]);
    }
}
