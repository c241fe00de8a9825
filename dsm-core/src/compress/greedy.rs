//! The one-pass compressor.

use super::slope_window::SlopeWindow;
use super::tube::{SUM_ROUNDING, Tube};
use crate::tolerance::Tolerance;
use crate::transmittance::Transmittance;
use crate::visibility::function::{VisibilityFunction, VisibilityView};
use crate::visibility::vertex::{SumVertex, Vertex};

/// The end condition of a compressor: its constraint on V(∞), the final value of a
/// function.
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
/// use dsm_core::{Tolerance, Vertex};
/// use dsm_core::detail::{End, GreedyCompressor};
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
    tolerance: Tolerance,
    tube: Tube<T>,
    /// The value that the function ends with, if it is known.
    last: Option<T>,
    /// V has ended where it isn't above this.
    ended: T::Sum,
    /// The current segment; closed while nothing is drawn.
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

    /// A compressor for one function. Cheap: make one for every pixel, or see
    /// [`Self::restart`].
    #[must_use]
    pub fn new(tolerance: Tolerance, end: End<T>) -> Self {
        let epsilon = f64::from(tolerance.epsilon());
        let (tube, last, ended) = match end {
            End::Known(last) => {
                let rounded = T::from_channels(|channel| last.as_ref()[channel].max(0.0) as f32);
                let ended = T::sum_from_channels(|channel| {
                    let rounded = f64::from(rounded.channel(channel));
                    last.as_ref()[channel].max(rounded) + SUM_ROUNDING
                });
                (Tube::above(rounded, epsilon), Some(rounded), ended)
            }
            End::Unknown => {
                (Tube::not_below(epsilon), None, T::sum_from_channels(|_| f64::NEG_INFINITY))
            }
        };
        let copying = tolerance.epsilon() < Self::COPY_BELOW;
        Self {
            tolerance,
            tube,
            last,
            ended,
            window: SlopeWindow::closed(T::CLEAR.to_sum()),
            state: if copying { State::Copying } else { State::Clear(None) },
            held: None,
            #[cfg(debug_assertions)]
            pushed: [None; 2],
        }
    }

    /// Forgets the function that was pushed so far; the next vertex is the
    /// first of one that ends with `end`.
    pub fn restart(&mut self, end: End<T>) {
        *self = Self::new(self.tolerance, end);
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
        #[cfg(debug_assertions)]
        vertices.iter().for_each(|vertex| self.check(vertex));
        if self.last.is_some() {
            self.draw_all(vertices, emit);
        } else if let Some((last, before)) = vertices.split_last() {
            if let Some(held) = self.held.take() {
                self.draw_all(&[held], emit);
            }
            self.draw_all(before, emit);
            self.held = Some(*last);
        }
    }

    #[inline]
    fn draw_all(&mut self, vertices: &[SumVertex<T>], emit: &mut impl FnMut(Vertex<T>)) {
        // V falls, so that the first vertex of its end can be searched for.
        let drawn = vertices.partition_point(|vertex| !self.has_ended(vertex));
        let (mut rest, end) = vertices.split_at(drawn);
        let (mut window, tube) = (self.window, self.tube);
        loop {
            rest = window.narrow_by_all(rest);
            let Some((vertex, others)) = rest.split_first() else { break };
            rest = others;
            if window.is_closed() {
                self.window = window;
                self.start_or_end(vertex, emit);
                window = self.window;
                continue;
            }
            if window.is_open() {
                window = tube.turn(&window, &vertex.value, emit);
            }
            if !window.narrow_by(vertex) {
                window = tube.step(&window, vertex, emit);
            }
        }
        self.window = window;
        for vertex in end {
            self.start_or_end(vertex, emit);
        }
    }

    /// True if V has fallen to its announced end in every channel.
    fn has_ended(&self, vertex: &SumVertex<T>) -> bool {
        let mut both = vertex.value.as_ref().iter().zip(self.ended.as_ref());
        both.all(|(value, ended)| value <= ended)
    }

    /// Takes a vertex before the first segment or behind the last.
    #[cold]
    #[inline(never)]
    fn start_or_end(&mut self, vertex: &SumVertex<T>, emit: &mut impl FnMut(Vertex<T>)) {
        match self.state {
            State::Copying => {
                let value = self.tube.round(&vertex.value, &self.window.origin().value);
                emit(Vertex::new(vertex.z, value));
                self.window = SlopeWindow::closed(value.to_sum());
            }
            State::Clear(_) if vertex.value == T::CLEAR.to_sum() || self.last == Some(T::CLEAR) => {
                self.state = State::Clear(Some(vertex.z));
            }
            State::Clear(origin) => {
                self.start(origin, vertex, emit);
                match self.last {
                    Some(last) if self.has_ended(vertex) => {
                        self.end_at(vertex, last, emit);
                    }
                    _ if self.window.narrow_by(vertex) => {}
                    _ => self.window = self.tube.step(&self.window, vertex, emit),
                }
            }
            State::Drawing => {
                if let Some(last) = self.last {
                    self.end_at(vertex, last, emit);
                }
            }
            State::Ended => {}
        }
    }

    /// Starts the first segment, at the last vertex of value 1.
    fn start(
        &mut self,
        origin: Option<f32>,
        next: &SumVertex<T>,
        emit: &mut impl FnMut(Vertex<T>),
    ) {
        let origin = Vertex::new(origin.unwrap_or(next.z), T::CLEAR);
        self.window = self.tube.start(origin, &next.value, emit);
        self.state = State::Drawing;
    }

    /// Ends V′ at the depth of `vertex` with the value `last`.
    fn end_at(&mut self, vertex: &SumVertex<T>, last: T, emit: &mut impl FnMut(Vertex<T>)) {
        self.tube.finish(self.window, vertex, last, emit);
        self.window = SlopeWindow::closed(last.to_sum());
        self.state = State::Ended;
    }

    /// Ends the function and writes what is left of it, at most two vertices.
    /// Before the next function: [`Self::restart`].
    pub fn finish(&mut self, emit: &mut impl FnMut(Vertex<T>)) {
        if let Some(held) = self.held.take() {
            let last = self.tube.round(&held.value, &self.window.origin().value);
            match self.state {
                State::Copying => emit(Vertex::new(held.z, last)),
                State::Clear(_) if last == T::CLEAR => {}
                State::Clear(origin) => {
                    self.start(origin, &held, emit);
                    self.end_at(&held, last, emit);
                }
                State::Drawing => self.end_at(&held, last, emit),
                State::Ended => {}
            }
        } else if self.state == State::Drawing {
            debug_assert!(false, "the function ends above the announced value");
            if self.window.is_open() {
                let floor = T::BLOCKED.to_sum();
                self.window = self.tube.turn(&self.window, &floor, emit);
            }
        }
        self.window = SlopeWindow::closed(T::BLOCKED.to_sum());
        self.state = State::Ended;
    }

    /// Checks the input against its contract.
    #[cfg(debug_assertions)]
    fn check(&mut self, vertex: &SumVertex<T>) {
        let [before, previous] = self.pushed;
        let above = previous.map_or(T::CLEAR.to_sum(), |previous| previous.value);
        let mut values = vertex.value.as_ref().iter().zip(above.as_ref());
        let slack = SUM_ROUNDING;
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

/// Compresses the function of `vertices`, which end with V(∞).
pub(super) fn compress_all<T: Transmittance>(
    tolerance: Tolerance,
    vertices: &[SumVertex<T>],
    emit: &mut impl FnMut(Vertex<T>),
) {
    if let Some(last) = vertices.last() {
        let mut compressor = GreedyCompressor::new(tolerance, End::Known(last.value));
        compressor.push_all(vertices, emit);
        compressor.finish(emit);
    }
}

/// Compresses a whole function; see [`GreedyCompressor`] for what holds of the
/// result. O(n).
///
/// ```
/// use dsm_core::detail::compress;
/// use dsm_core::{Tolerance, Vertex, VisibilityFunction};
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
