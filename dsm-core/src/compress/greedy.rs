//! The one-pass compressor.

use super::slope_window::{SlopeWindow, Target};
use crate::{SumVertex, Tolerance, Transmittance, Vertex, VisibilityFunction, VisibilityView};

/// What a compressor is told of V(∞), the value that a function ends with.
///
/// A one-pass monotone compressor ends exactly only if it never goes below
/// the end. So it has to know it, or must not go below V at all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End<T: Transmittance> {
    /// V(∞), the value of the last vertex. V′ keeps within
    /// [max(V − ε, V(∞)), V + ε].
    Known(T::Sum),
    /// V(∞) is not known. V′ keeps within [V, V + ε], which costs vertices.
    Unknown,
}

/// A streaming compressor of visibility functions: the greedy algorithm of
/// Lokovic & Veach 2000, §3.3, for one channel or for three together (§5.2:
/// they share their depths, and a segment ends when any of them has to).
///
/// It reads the vertices of V, in `f64`, and writes those of V′, one at a time
/// with constant state and O(1) work each. For every V that satisfies the
/// invariant of [`VisibilityView`], but for sums that are off by up to 2⁻⁴⁰:
///
/// - |V′ − V| ≤ ε at both sides of every vertex, so everywhere, in every
///   channel, with `f32` values; 2⁻²⁴ are left for rounding at a lookup;
/// - V′ satisfies the invariant as well, and its last value is V(∞) rounded
///   to `f32`: what is opaque stays exactly opaque;
/// - the depths of V′ are depths of V, and V′ has no more vertices than V. A
///   function that never falls has none.
///
/// That is more than the paper asks for: here slopes are never positive, the
/// first segment starts at the last vertex of value 1 instead of at (0, 1),
/// and the tube ends at V(∞).
///
/// Below [`Self::COPY_BELOW`] rounding would fill the tube: vertices are
/// copied, each value rounded to the nearest `f32`, an error of at most 2⁻²⁵.
///
/// ```
/// use dsm_core::{End, GreedyCompressor, Tolerance, Vertex};
///
/// // Ten sheets that each stop a twentieth of the light.
/// let left = |sheets: u8| [f64::from(20 - sheets) / 20.0];
/// let mut compressor = GreedyCompressor::<f32>::new(Tolerance::new(0.06)?, End::Known(left(10)));
/// let mut compressed = Vec::new();
/// let mut emit = |vertex| compressed.push(vertex);
/// for sheet in 1..=10 {
///     compressor.push(Vertex::new(f32::from(sheet), left(sheet - 1)), &mut emit);
///     compressor.push(Vertex::new(f32::from(sheet), left(sheet)), &mut emit);
/// }
/// compressor.finish(&mut emit);
/// assert_eq!(compressed, [Vertex::new(1.0, 1.0), Vertex::new(10.0, 0.5)]);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct GreedyCompressor<T: Transmittance> {
    target: Target<T>,
    /// How far below the next vertex a segment may end: `target.down` less
    /// half a unit in the last place, so that rounding doesn't leave the tube.
    end_down: f64,
    /// The value that the function ends with, if it is known.
    last: Option<T>,
    /// V has ended where it isn't above this.
    ended: T::Sum,
    window: SlopeWindow<T>,
    state: State,
    /// The last vertex while nobody knows whether it is the last.
    held: Option<SumVertex<T>>,
    #[cfg(debug_assertions)]
    pushed: [Option<SumVertex<T>>; 2],
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    /// The vertices are copied.
    Copying,
    /// No vertex was below 1 yet; the depth of the last one.
    Clear(Option<f32>),
    /// A segment is being drawn.
    Drawing,
    /// V(∞) was reached and written.
    Ended,
}

impl<T: Transmittance> GreedyCompressor<T> {
    /// The tolerance below which vertices are copied.
    pub const COPY_BELOW: f32 = 1.0 / (1 << 20) as f32;

    /// What the tube is narrower than ε: an end that is rounded to `f32`, or
    /// moved into the tube first, is off by 2⁻²⁴ at most, V(∞) by 2⁻²⁵, and
    /// a lookup rounds by 2⁻²⁵.
    const MARGIN: f64 = 1.0 / (1 << 22) as f64;

    /// Half a unit in the last place of the `f32`s in [½, 1].
    const HALF_UNIT: f64 = 1.0 / (1 << 25) as f64;

    /// What a sum may be off by because it was added up in another order: as
    /// much as V may rise, leave [0, 1] or miss the announced end.
    const SUM_ROUNDING: f64 = 1.0 / (1_u64 << 40) as f64;

    /// A compressor for one function. Cheap: make one for every pixel, or see
    /// [`Self::restart`].
    #[must_use]
    pub fn new(tolerance: Tolerance, end: End<T>) -> Self {
        let epsilon = f64::from(tolerance.epsilon()) - Self::MARGIN;
        let target =
            Target { down: epsilon, up: epsilon, floor: T::BLOCKED.to_sum(), highest_slope: 0.0 };
        let mut compressor = Self {
            target,
            end_down: 0.0,
            last: None,
            ended: target.floor,
            window: SlopeWindow::closed(T::CLEAR.to_sum()),
            state: State::Copying,
            held: None,
            #[cfg(debug_assertions)]
            pushed: [None; 2],
        };
        compressor.restart(end);
        compressor
    }

    /// Forgets the function that was pushed so far; the next vertex is the
    /// first of one that ends with `end`.
    pub fn restart(&mut self, end: End<T>) {
        match end {
            End::Known(last) => {
                let rounded = T::from_channels(|channel| last.as_ref()[channel].max(0.0) as f32);
                let floor = rounded.to_sum();
                self.last = Some(rounded);
                self.target = Target { down: self.target.up, floor, ..self.target };
                self.end_down = self.target.up - Self::HALF_UNIT;
                self.ended = T::sum_from_channels(|channel| {
                    last.as_ref()[channel].max(floor.as_ref()[channel]) + Self::SUM_ROUNDING
                });
            }
            End::Unknown => {
                self.last = None;
                self.target = Target { down: 0.0, floor: T::BLOCKED.to_sum(), ..self.target };
                self.end_down = 0.0;
                self.ended = T::sum_from_channels(|_| f64::NEG_INFINITY);
            }
        }
        let copying = self.target.up + Self::MARGIN < f64::from(Self::COPY_BELOW);
        self.state = if copying { State::Copying } else { State::Clear(None) };
        self.window = SlopeWindow::closed(T::CLEAR.to_sum());
        self.held = None;
        #[cfg(debug_assertions)]
        {
            self.pushed = [None; 2];
        }
    }

    /// Takes the next vertex of V and gives those of V′ that are settled by
    /// it, at most two, to `emit`.
    ///
    /// The vertices must satisfy the invariant of [`VisibilityView`] and end
    /// as announced (asserted in debug builds). If they don't, neither will
    /// V′, but nothing worse happens.
    #[inline]
    pub fn push(&mut self, vertex: SumVertex<T>, emit: &mut impl FnMut(Vertex<T>)) {
        self.push_all(std::slice::from_ref(&vertex), emit);
    }

    /// Pushes several vertices; faster than one at a time.
    #[inline]
    pub fn push_all(&mut self, vertices: &[SumVertex<T>], emit: &mut impl FnMut(Vertex<T>)) {
        // A copy of its own, because `self` is passed on: it stays in registers.
        let mut window = self.window;
        for vertex in vertices {
            self.check(vertex);
            let vertex = if self.last.is_some() {
                *vertex
            } else if let Some(held) = self.held.replace(*vertex) {
                held
            } else {
                continue;
            };
            if self.has_ended(&vertex) || !window.narrow(&vertex) {
                self.window = window;
                self.turn(&vertex, emit);
                window = self.window;
            }
        }
        self.window = window;
    }

    /// Ends the function and writes what is left of it, at most two vertices.
    /// Before the next function: [`Self::restart`].
    pub fn finish(&mut self, emit: &mut impl FnMut(Vertex<T>)) {
        if let Some(held) = self.held.take() {
            let last = self.round(&held.value);
            match self.state {
                State::Copying => emit(Vertex::new(held.z, last)),
                State::Clear(_) if last == T::CLEAR => {}
                State::Clear(origin) => {
                    self.start(origin, &held, emit);
                    self.finish_at(&held, last, emit);
                }
                State::Drawing => self.finish_at(&held, last, emit),
                State::Ended => {}
            }
        } else if self.state == State::Drawing {
            debug_assert!(false, "the function ends above the announced value");
            if self.window.is_open() {
                let floor = self.target.floor;
                self.end_segment(&floor, emit);
            }
        }
        self.state = State::Ended;
    }

    #[inline(always)]
    fn has_ended(&self, vertex: &SumVertex<T>) -> bool {
        let mut ended = true;
        for channel in 0..T::CHANNELS {
            ended &= vertex.value.as_ref()[channel] <= self.ended.as_ref()[channel];
        }
        ended
    }

    /// Everything but going on with the current segment.
    #[cold]
    #[inline(never)]
    fn turn(&mut self, vertex: &SumVertex<T>, emit: &mut impl FnMut(Vertex<T>)) {
        match self.state {
            State::Copying => {
                let value = self.round(&vertex.value);
                emit(Vertex::new(vertex.z, value));
                self.window = SlopeWindow::closed(value.to_sum());
            }
            State::Ended => {}
            State::Clear(_) if vertex.value == T::CLEAR.to_sum() || self.last == Some(T::CLEAR) => {
                self.state = State::Clear(Some(vertex.z));
            }
            State::Clear(origin) => {
                self.start(origin, vertex, emit);
                self.draw(vertex, emit);
            }
            State::Drawing => self.draw(vertex, emit),
        }
    }

    /// Starts the first segment, at the last vertex of value 1.
    fn start(
        &mut self,
        origin: Option<f32>,
        next: &SumVertex<T>,
        emit: &mut impl FnMut(Vertex<T>),
    ) {
        self.state = State::Drawing;
        self.continue_from(Vertex::new(origin.unwrap_or(next.z), T::CLEAR), &next.value, emit);
    }

    /// Goes to `vertex`, to which the current segment cannot go on.
    fn draw(&mut self, vertex: &SumVertex<T>, emit: &mut impl FnMut(Vertex<T>)) {
        if let Some(last) = self.last
            && self.has_ended(vertex)
        {
            return self.finish_at(vertex, last, emit);
        }
        if self.window.is_open() {
            self.end_segment(&vertex.value, emit);
        }
        if !self.window.narrow(vertex) {
            self.step(vertex, emit);
        }
    }

    /// Ends the current segment at the last vertex it passed. `next` is the
    /// value of the vertex that it couldn't pass.
    fn end_segment(&mut self, next: &T::Sum, emit: &mut impl FnMut(Vertex<T>)) {
        let end = self.window.end();
        let value = self.round(&T::sum_from_channels(|channel| {
            end.value.as_ref()[channel].max(next.as_ref()[channel] - self.end_down)
        }));
        self.continue_from(Vertex::new(end.z, value), next, emit);
    }

    /// Goes to `vertex` at the origin's own depth: a step, unless the origin
    /// will do in every channel.
    fn step(&mut self, vertex: &SumVertex<T>, emit: &mut impl FnMut(Vertex<T>)) {
        let origin = self.window.origin();
        // What rounding did to the origin is no reason for a step.
        let up = self.target.up + 2.0 * Self::HALF_UNIT;
        let mut both = origin.value.as_ref().iter().zip(vertex.value.as_ref());
        if both.all(|(&from, &to)| from <= to + up) {
            return;
        }
        let value = self.round(&vertex.value);
        self.continue_from(Vertex::new(vertex.z, value), &vertex.value, emit);
    }

    /// Ends V′ at the depth of `vertex` with the value `last`.
    fn finish_at(&mut self, vertex: &SumVertex<T>, last: T, emit: &mut impl FnMut(Vertex<T>)) {
        self.state = State::Ended;
        let end = Vertex::new(vertex.z, last.to_sum());
        if self.window.is_open() && !self.window.admits(&end) {
            self.end_segment(&vertex.value, emit);
        }
        if self.window.origin().value != end.value {
            emit(Vertex::new(vertex.z, last));
        }
    }

    /// Writes `origin` and starts a segment there. No vertex from now on lies
    /// above `next`.
    fn continue_from(
        &mut self,
        origin: Vertex<T>,
        next: &T::Sum,
        emit: &mut impl FnMut(Vertex<T>),
    ) {
        emit(origin);
        let origin = Vertex::new(origin.z, origin.value.to_sum());
        self.window = SlopeWindow::from_origin(origin, &self.target);
        self.window.never_rise_above(next, Self::SUM_ROUNDING);
    }

    /// The nearest `f32`s that V′ may fall to.
    fn round(&self, value: &T::Sum) -> T {
        let (floor, highest) = (&self.target.floor, self.window.origin().value);
        T::from_channels(|channel| {
            let raised = value.as_ref()[channel].max(floor.as_ref()[channel]);
            raised.min(highest.as_ref()[channel]) as f32
        })
    }

    #[cfg(not(debug_assertions))]
    #[inline(always)]
    fn check(&mut self, _vertex: &SumVertex<T>) {}

    /// Holds the input to what it promises.
    #[cfg(debug_assertions)]
    fn check(&mut self, vertex: &SumVertex<T>) {
        let [before, previous] = self.pushed;
        let above = previous.map_or(T::CLEAR.to_sum(), |previous| previous.value);
        let mut values = vertex.value.as_ref().iter().zip(above.as_ref());
        let slack = Self::SUM_ROUNDING;
        debug_assert!(
            values.all(|(value, above)| (-slack..=above + slack).contains(value)),
            "values must fall from 1 and stay in [0, 1]: {vertex:?} after {previous:?}"
        );
        debug_assert!(
            previous.is_some() || vertex.value == above,
            "the first value must be 1: {vertex:?}"
        );
        debug_assert!(
            (previous.map_or(0.0, |previous| previous.z)..f32::INFINITY).contains(&vertex.z),
            "z must be finite and must not fall: {vertex:?} after {previous:?}"
        );
        debug_assert!(
            before.is_none_or(|before| before.z < vertex.z),
            "at most two vertices may share a z: {vertex:?}"
        );
        self.pushed = [previous, Some(*vertex)];
    }
}

/// Compresses a whole function; see [`GreedyCompressor`] for what holds of the
/// result. O(n).
///
/// ```
/// use dsm_core::{Tolerance, Vertex, VisibilityFunction, compress};
///
/// let ramp = (0..=100_u8).map(|i| Vertex::new(f32::from(i), 1.0 - f32::from(i) / 200.0));
/// let function = VisibilityFunction::new(ramp)?;
/// let compressed = compress(function.view(), Tolerance::new(0.01)?);
/// assert_eq!(compressed.view().depths(), [0.0, 100.0]);
/// assert_eq!(compressed.view().last(), 0.5);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[must_use]
pub fn compress<T: Transmittance>(
    function: VisibilityView<'_, T>,
    tolerance: Tolerance,
) -> VisibilityFunction<T> {
    let mut compressed = Vec::new();
    let mut emit = |vertex| compressed.push(vertex);
    let end = End::Known(function.last().to_sum());
    let mut compressor = GreedyCompressor::new(tolerance, end);
    for vertex in function.vertices() {
        compressor.push(Vertex::new(vertex.z, vertex.value.to_sum()), &mut emit);
    }
    compressor.finish(&mut emit);
    VisibilityFunction::unchecked(&compressed)
}
