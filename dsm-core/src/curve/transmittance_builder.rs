//! Transmittance functions of single rays, from their hits.

use super::compensated::RunningTransmittance;
use super::depth_sort::sort_by_depth;
use super::optical_depth::{OpticalDepth, Stretch};
use super::transmittance_function::TransmittanceFunction;
use crate::hits::hit::RayHits;
use crate::tolerance::Tolerance;
use crate::transmittance::Transmittance;
use crate::visibility::vertex::SumVertex;
use crate::visibility::vertex_writer::VertexWriter;

/// A builder of transmittance functions, one ray after the other; keeps its memory
/// in between.
///
/// Surfaces and segments come in any order, which changes the result by
/// rounding at most; surfaces at one depth make one step, extinctions of
/// overlapping segments add. A ray's surfaces and segments together must
/// number below 2³¹.
///
/// **Chords.** The exponential of a medium is cut into chords, each as long as
/// the curvature at its near end allows: |f″| ≤ (κ² + |κ′|) f for extinction
/// κ, and a chord of length h misses f by at most h²/8 max |f″|. Chords end at
/// `f32` depths; between neighbouring ones there is nothing to miss. A stretch
/// that falls by less than the chord error is one chord, however long.
///
/// **Cost.** With n surfaces and segments and chord error e: O((n + vertices)
/// log n) time and, because falls sum to 1, at most about
/// 4n + 3 √(n / e) + 3 / √e vertices a channel, whatever the input.
///
/// ```
/// use dsm_core::{RayHits, Tolerance};
/// use dsm_core::detail::{TransmittanceBuilder, TransmittanceFunction};
///
/// let mut hits = RayHits::<f32>::default();
/// let mut builder = TransmittanceBuilder::new(Tolerance::new(0.02)?.chord());
/// let mut function = TransmittanceFunction::default();
/// for opacity in [0.25, 0.5] {
///     hits.clear();
///     hits.push_slab(1.0, 2.0, opacity)?;
///     builder.build(&hits, &mut function);
///     assert!((function.last()[0] - f64::from(1.0 - opacity)).abs() < 1e-15);
/// }
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct TransmittanceBuilder<T: Transmittance> {
    chord_error: f64,
    /// Depth bits above the index of what happens there: surfaces first, then
    /// near ends, then far ends of segments.
    events: Vec<u64>,
    spare: Vec<u64>,
    optical_depth: OpticalDepth<T>,
}

impl<T: Transmittance> TransmittanceBuilder<T> {
    /// A builder whose chords miss exponentials by at most `chord_error`;
    /// anything below [`Tolerance::CHORD_FLOOR`] counts as that.
    #[must_use]
    pub fn new(chord_error: f64) -> Self {
        Self {
            chord_error: chord_error.max(Tolerance::CHORD_FLOOR),
            events: Vec::new(),
            spare: Vec::new(),
            optical_depth: OpticalDepth::default(),
        }
    }

    /// Replaces `function` by the transmittance along a ray with these `hits`.
    pub fn build(&mut self, hits: &RayHits<T>, function: &mut TransmittanceFunction<T>) {
        self.sort_events(hits);
        self.optical_depth.clear();
        function.vertices.clear();
        function.curved = false;
        let vertices = &mut function.vertices;
        let mut writer = VertexWriter::<T, _>::new(|vertex| vertices.push(vertex));
        let mut surface_transmittance = RunningTransmittance::<T>::clear();
        let (surfaces, segments) = (hits.surfaces(), hits.segments());
        let mut here = 0.0;
        let mut events = self.events.iter().peekable();
        while let Some(&first) = events.peek() {
            let z = f32::from_bits((first >> 32) as u32);
            if !self.optical_depth.is_outside() {
                let stretch = self.optical_depth.advance(here, z);
                let passing = Passing { stretch, surface_transmittance, error: self.chord_error };
                let end = transmittance(&surface_transmittance, self.optical_depth.value());
                function.curved |= end != writer.value();
                passing.draw(here, z, end, &mut writer);
            } else {
                writer.line_to(z, writer.value());
            }
            while let Some(&event) = events.next_if(|&event| event >> 32 == first >> 32) {
                let index = event as u32 as usize;
                if let Some(surface) = surfaces.get(index) {
                    surface_transmittance.block(surface.opacity);
                } else if let Some(segment) = segments.get(index - surfaces.len()) {
                    self.optical_depth.enter(segment);
                } else {
                    let segment = &segments[index - surfaces.len() - segments.len()];
                    self.optical_depth.leave(segment);
                }
            }
            let value = transmittance(&surface_transmittance, self.optical_depth.value());
            writer.line_to(z, value);
            if value == T::BLOCKED.to_sum() {
                break;
            }
            here = z;
        }
    }

    /// Everything that happens along the ray, front to back. What changes
    /// nothing is left out.
    fn sort_events(&mut self, hits: &RayHits<T>) {
        let event =
            |depth: f32, index: usize| u64::from(depth.to_bits()) << 32 | u64::from(index as u32);
        let (surfaces, segments) = (hits.surfaces(), hits.segments());
        self.events.clear();
        for (index, surface) in surfaces.iter().enumerate() {
            if surface.opacity != T::splat(0.0) {
                self.events.push(event(surface.depth, index));
            }
        }
        let clear = T::splat(0.0).to_sum();
        for (index, segment) in segments.iter().enumerate() {
            if segment.near_extinction != clear || segment.far_extinction != clear {
                let near = surfaces.len() + index;
                self.events.push(event(segment.near, near));
                self.events.push(event(segment.far, near + segments.len()));
            }
        }
        sort_by_depth(&mut self.events, &mut self.spare);
    }
}

/// The transmittance of surfaces and an optical depth together.
fn transmittance<T: Transmittance>(
    surfaces: &RunningTransmittance<T>,
    optical_depth: T::Sum,
) -> T::Sum {
    T::sum_from_channels(|channel| match optical_depth.as_ref()[channel] {
        0.0 => surfaces.channel(channel),
        optical_depth => surfaces.channel(channel) * (-optical_depth).exp(),
    })
}

impl<T: Transmittance> TransmittanceFunction<T> {
    /// The transmittance along a ray with these `hits`, with chords that miss the
    /// exponentials of media by at most `chord_error`. Over many rays a
    /// [`TransmittanceBuilder`] does this without allocating.
    #[must_use]
    pub fn new(hits: &RayHits<T>, chord_error: f64) -> Self {
        let mut function = Self::default();
        TransmittanceBuilder::new(chord_error).build(hits, &mut function);
        function
    }
}

/// A medium behind the surfaces so far.
struct Passing<T: Transmittance> {
    stretch: Stretch<T>,
    surface_transmittance: RunningTransmittance<T>,
    error: f64,
}

impl<T: Transmittance> Passing<T> {
    /// Draws the chords from `near`, where the writer is, to `end` at `far`.
    fn draw(
        &self,
        near: f32,
        far: f32,
        end: T::Sum,
        writer: &mut VertexWriter<T, impl FnMut(SumVertex<T>)>,
    ) {
        let mut z = near;
        loop {
            z = self.next(z, far, writer.value(), end);
            if z >= far {
                break;
            }
            let value = transmittance(
                &self.surface_transmittance,
                self.stretch.optical_depth(f64::from(z)),
            );
            writer.line_to(
                z,
                T::sum_from_channels(|channel| value.as_ref()[channel].max(end.as_ref()[channel])),
            );
        }
        writer.line_to(far, end);
    }

    /// The depth where the chord from `z`, with value `value`, may end.
    fn next(&self, z: f32, far: f32, value: T::Sum, end: T::Sum) -> f32 {
        let here = f64::from(z);
        let mut length = f64::INFINITY;
        for channel in 0..T::CHANNELS {
            let (value, end) = (value.as_ref()[channel], end.as_ref()[channel]);
            // Function and chord both lie between `value` and `end`.
            if value - end > self.error {
                length = length.min(self.stretch.chord_length(channel, here, value, self.error));
            }
        }
        let next = here + length;
        if next >= f64::from(far) {
            return far;
        }
        let rounded = next as f32;
        let below = if f64::from(rounded) > next { rounded.next_down() } else { rounded };
        below.max(z.next_up())
    }
}
