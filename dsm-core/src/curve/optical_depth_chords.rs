//! The optical depth along single rays, cut into few chords.

use super::depth_sort::sort_by_depth;
use super::optical_depth::OpticalDepth;
use crate::hits::hit::VolumeSegment;
use crate::tolerance::Tolerance;
use crate::transmittance::Transmittance;
use crate::visibility::vertex::{SumVertex, Vertex};

/// The share of the error that straight pieces of curved stretches may have; chords over
/// several pieces have the rest.
const OF_PIECES: f64 = 0.25;

/// Straight pieces for each vertex that may be kept, at most.
const PIECES: usize = 8;

/// How much the error grows where a ray would have more vertices than it may.
const COARSER: f64 = 4.0;

/// A builder of the optical depth along rays, one after the other: a polyline whose
/// vertices lie on the curve. Keeps its memory in between.
///
/// Between two vertices the polyline is off by the error at most, and so is the optical
/// depth of any stretch from a vertex on; of any other stretch twice that. Where extinctions
/// of overlapping segments add, so do their optical depths.
///
/// A ray gets at most as many vertices as it is told: where that is too few, the error is
/// four times as large, and so on. **Cost.** O((n + p) log n) for n segments and the p
/// straight pieces of their curves, about √(D / e) of a segment of optical depth D.
///
/// ```
/// use dsm_core::{RayHits, VolumeSample};
/// use dsm_core::detail::OpticalDepthChords;
///
/// let mut hits = RayHits::<f32>::default();
/// let fog = [0.0, 1.0, 1.0, 0.0].into_iter().zip([1.0, 2.0, 3.0, 4.0]);
/// let fog: Vec<_> = fog.map(|(extinction, depth)| VolumeSample { depth, extinction }).collect();
/// hits.push_volume(&fog, 1.0)?;
/// let mut chords = OpticalDepthChords::<f32>::new(0.01, 64);
/// let vertices = chords.build(hits.segments(), 0.0);
/// assert_eq!((vertices[0].z, vertices[0].value), (1.0, [0.0]));
/// assert!((vertices[vertices.len() - 1].value[0] - 2.0).abs() < 1e-12);
/// assert!(vertices.len() < 20);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct OpticalDepthChords<T: Transmittance> {
    error: f64,
    most: usize,
    segments: Vec<VolumeSegment<T>>,
    /// Depth bits above the index of what happens there: near ends, then far ends.
    events: Vec<u64>,
    spare: Vec<u64>,
    optical_depth: OpticalDepth<T>,
    /// How far pieces are off.
    drawn: f64,
    /// The curve in straight pieces.
    pieces: Vec<SumVertex<T>>,
    chords: Vec<SumVertex<T>>,
}

impl<T: Transmittance> OpticalDepthChords<T> {
    /// A builder of polylines within `error`, of which anything below
    /// [`Tolerance::CHORD_FLOOR`] counts as that, with `most` vertices, at least 2.
    #[must_use]
    pub fn new(error: f64, most: usize) -> Self {
        Self {
            error: error.max(Tolerance::CHORD_FLOOR),
            most: most.max(2),
            segments: Vec::new(),
            events: Vec::new(),
            spare: Vec::new(),
            optical_depth: OpticalDepth::default(),
            drawn: 0.0,
            pieces: Vec::new(),
            chords: Vec::new(),
        }
    }

    /// The optical depth, since depth `from`, of the part of `segments` behind it: the
    /// vertices, front to back, with the first at 0; none if there is nothing.
    pub fn build(&mut self, segments: &[VolumeSegment<T>], from: f32) -> &[SumVertex<T>] {
        let clear = T::splat(0.0).to_sum();
        let seen = segments
            .iter()
            .filter(|segment| segment.near_extinction != clear || segment.far_extinction != clear);
        self.segments.clear();
        self.segments.extend(seen.filter_map(|segment| segment.behind(from)));
        self.sort_events();
        self.drawn = OF_PIECES * self.error;
        loop {
            if self.draw() {
                self.cut((1.0 - OF_PIECES) / OF_PIECES * self.drawn);
                if self.chords.len() <= self.most {
                    return &self.chords;
                }
            }
            self.drawn *= COARSER;
        }
    }

    /// What the last polyline stands for, in straight pieces, and how far those are off the
    /// curve at most.
    #[must_use]
    pub fn pieces(&self) -> (&[SumVertex<T>], f64) {
        (&self.pieces, self.drawn)
    }

    fn sort_events(&mut self) {
        let event =
            |depth: f32, index: usize| u64::from(depth.to_bits()) << 32 | u64::from(index as u32);
        let count = self.segments.len();
        self.events.clear();
        for (index, segment) in self.segments.iter().enumerate() {
            self.events.push(event(segment.near, index));
            self.events.push(event(segment.far, count + index));
        }
        sort_by_depth(&mut self.events, &mut self.spare);
    }

    /// Draws the curve in straight pieces; false if they were far more than are kept.
    fn draw(&mut self) -> bool {
        let Self { most, drawn, segments, events, optical_depth, pieces, .. } = self;
        let room = (PIECES * *most + events.len()) as f64;
        optical_depth.clear();
        pieces.clear();
        let mut here = 0.0;
        let mut events = events.iter().peekable();
        while let Some(&first) = events.peek() {
            let z = f32::from_bits((first >> 32) as u32);
            if !optical_depth.is_outside() {
                let stretch = optical_depth.advance(here, z);
                let length = f64::from(z) - f64::from(here);
                let count = (length * (stretch.steepest() / (8.0 * *drawn)).sqrt()).ceil();
                if pieces.len() as f64 + count > room {
                    return false;
                }
                let count = count as u32;
                let mut last = here;
                for piece in 1..count {
                    let at = f64::from(here) + length * f64::from(piece) / f64::from(count);
                    let at = at as f32;
                    if at > last && at < z {
                        last = at;
                        push::<T>(pieces, at, stretch.optical_depth(at.into()));
                    }
                }
            }
            while let Some(&event) = events.next_if(|&event| event >> 32 == first >> 32) {
                let index = event as u32 as usize;
                match segments.get(index) {
                    Some(segment) => optical_depth.enter(segment),
                    None => optical_depth.leave(&segments[index - segments.len()]),
                }
            }
            push::<T>(pieces, z, optical_depth.value());
            here = z;
        }
        true
    }

    /// Chords from piece to piece, each as long as may be found without looking back.
    fn cut(&mut self, error: f64) {
        let Self { pieces, chords, .. } = self;
        chords.clear();
        let Some(&first) = pieces.first() else { return };
        chords.push(first);
        let (mut start, mut before) = (first, first);
        let none = [[f64::NEG_INFINITY, f64::INFINITY]; 3];
        let mut window = none;
        for &next in &pieces[1..] {
            let slopes = slopes::<T>(&start, &next, error);
            let fits = (0..T::CHANNELS).all(|channel| {
                let [least, most] = window[channel];
                (least..=most).contains(&slopes[channel][1])
            });
            if !fits {
                chords.push(before);
                start = before;
                window = none;
            }
            let slopes = if fits { slopes } else { self::slopes::<T>(&start, &next, error) };
            for (own, [least, _, most]) in window.iter_mut().zip(slopes) {
                *own = [own[0].max(least), own[1].min(most)];
            }
            before = next;
        }
        chords.push(before);
        // Nothing lies behind what no longer grows.
        while let [.., last, end] = chords.as_slice() {
            if last.value != end.value {
                return;
            }
            chords.pop();
        }
        chords.clear();
    }
}

/// The slopes of lines from `start` that pass a vertex below it by the error, through it,
/// and above it.
fn slopes<T: Transmittance>(
    start: &SumVertex<T>,
    vertex: &SumVertex<T>,
    error: f64,
) -> [[f64; 3]; 3] {
    let mut slopes = [[0.0; 3]; 3];
    let distance = f64::from(vertex.z) - f64::from(start.z);
    for (channel, slopes) in slopes.iter_mut().enumerate().take(T::CHANNELS) {
        let rise = vertex.value.as_ref()[channel] - start.value.as_ref()[channel];
        *slopes = [rise - error, rise, rise + error].map(|rise| rise / distance);
    }
    slopes
}

/// Appends a vertex that lies behind the last and not below it.
fn push<T: Transmittance>(pieces: &mut Vec<SumVertex<T>>, z: f32, value: T::Sum) {
    let Some(last) = pieces.last() else {
        pieces.push(Vertex::new(z, value));
        return;
    };
    if z > last.z {
        let value = T::sum_from_channels(|channel| {
            value.as_ref()[channel].max(last.value.as_ref()[channel])
        });
        pieces.push(Vertex::new(z, value));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hits::hit::{RayHits, VolumeSample};
    use crate::transmittance::Rgb;

    /// Two clouds that overlap, the second coloured.
    fn clouds() -> RayHits<Rgb> {
        let mut hits = RayHits::default();
        let mut state = 1_u32;
        for (first, tint) in [(1.0, Rgb::splat(1.0)), (2.25, Rgb::new(0.5, 2.0, 0.0))] {
            let samples = (0..60_u8).map(|at| {
                state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
                let extinction = (state >> 8) as f32 / 16_777_216.0 * 3.0;
                VolumeSample {
                    depth: first + f32::from(at) / 16.0,
                    extinction: Rgb::from_channels(|channel| tint.channel(channel) * extinction),
                }
            });
            hits.push_volume(&samples.collect::<Vec<_>>(), 1.25).unwrap();
        }
        hits
    }

    /// The optical depth up to `z`, segment by segment.
    fn naive(hits: &RayHits<Rgb>, from: f64, z: f64) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for segment in hits.segments() {
            let [near, far] = [segment.near, segment.far].map(f64::from);
            let at = |channel: usize, z: f64| {
                let [a, b] = [segment.near_extinction[channel], segment.far_extinction[channel]];
                a + (b - a) * (z - near) / (far - near)
            };
            let (start, end) = (near.max(from), far.min(z));
            if start < end {
                for (channel, sum) in sum.iter_mut().enumerate() {
                    *sum += 0.5 * (at(channel, start) + at(channel, end)) * (end - start);
                }
            }
        }
        sum
    }

    fn at(vertices: &[SumVertex<Rgb>], z: f64, channel: usize) -> f64 {
        let next = vertices.partition_point(|vertex| f64::from(vertex.z) <= z);
        if next == 0 {
            return 0.0;
        }
        let near = vertices[next - 1];
        let Some(far) = vertices.get(next) else { return near.value[channel] };
        let share = (z - f64::from(near.z)) / (f64::from(far.z) - f64::from(near.z));
        near.value[channel] + share * (far.value[channel] - near.value[channel])
    }

    #[test]
    fn chords_keep_to_the_error_and_are_few() {
        let hits = clouds();
        let mut counts = Vec::new();
        for (error, from) in [(0.0, 0.0), (1e-3, 0.0), (0.02, 2.4), (0.3, 0.0)] {
            let mut chords = OpticalDepthChords::new(error, 1 << 16);
            let vertices = chords.build(hits.segments(), from);
            counts.push(vertices.len());
            assert!(vertices.windows(2).all(|pair| pair[0].z < pair[1].z));
            assert_eq!(vertices[0].z, from.max(1.0));
            for step in 0..4000 {
                let z = 0.5 + f64::from(step) / 500.0;
                let truth = naive(&hits, from.into(), z);
                for (channel, truth) in truth.into_iter().enumerate() {
                    let off = (at(vertices, z, channel) - truth).abs();
                    assert!(off <= error.max(5e-7) * 1.0001 + 1e-12, "{error} {z} {off}");
                }
            }
            for vertex in vertices {
                let truth = naive(&hits, from.into(), vertex.z.into());
                assert!(
                    (0..3).all(|channel| (vertex.value[channel] - truth[channel]).abs() < 1e-9)
                );
            }
        }
        // Two clouds of 59 segments each, of random extinctions: each bends by 0.03 at most.
        assert!(counts[3] < 10 && counts[2] < 118 && counts[1] < 800, "{counts:?}");
    }

    #[test]
    fn there_are_no_more_than_there_may_be() {
        let mut chords = OpticalDepthChords::new(1e-6, 16);
        let hits = clouds();
        let count = chords.build(hits.segments(), 0.0).len();
        assert!((4..=16).contains(&count), "{count}");
        // However steep it is.
        let mut steep = RayHits::<f32>::default();
        let wall = [(1.0, 0.0), (2.0, 1e30), (3.0, 0.0)];
        let wall = wall.map(|(depth, extinction)| VolumeSample { depth, extinction });
        steep.push_volume(&wall, 1.0).unwrap();
        let mut chords = OpticalDepthChords::new(1e-6, 16);
        assert!(chords.build(steep.segments(), 0.0).len() <= 16);
    }

    #[test]
    fn what_takes_nothing_has_no_vertices() {
        let mut chords = OpticalDepthChords::new(0.01, 64);
        let mut hits = RayHits::<f32>::default();
        assert_eq!(chords.build(hits.segments(), 0.0), []);
        hits.push_slab(1.0, 2.0, 0.0).unwrap();
        hits.push_slab(1.0, 2.0, 0.5).unwrap();
        assert_eq!(chords.build(hits.segments(), 2.0), []);
        let vertices = chords.build(hits.segments(), 1.5);
        assert_eq!(vertices.len(), 2);
        assert!((vertices[1].value[0] - 0.5 * 2.0_f64.ln()).abs() < 1e-7);
    }
}
