//! The sweep of pixels that hit nothing but surfaces, straight from the hits.

use super::compensated::RunningTransmittance;
use super::depth_sort::sort_by_depth;
use super::steps::{End, FinalSum, draw_steps};
use crate::transmittance::Transmittance;
use crate::visibility::vertex::SumVertex;

/// Adds up what the surfaces in the way of a pixel's samples let through: the
/// same sum as of their transmittance functions
/// ([`VisibilitySweep`](super::sweep::VisibilitySweep)), which nobody has to
/// make. All hits are sorted by depth once, and each changes the running
/// transmittance of its sample (Lokovic & Veach 2000, §3.2 and §5.1). Keeps
/// its memory from pixel to pixel.
#[derive(Clone, Debug)]
pub(crate) struct SurfaceSweep<T: Transmittance> {
    /// Depth bits above the hit.
    events: Vec<u64>,
    spare: Vec<u64>,
    /// The transmittance of the surfaces so far, of every sample.
    left: Vec<RunningTransmittance<T>>,
    /// Depth bits and height of what changes the sum, front to back.
    steps: Vec<(u32, T::Sum)>,
}

impl<T: Transmittance> Default for SurfaceSweep<T> {
    fn default() -> Self {
        Self { events: Vec::new(), spare: Vec::new(), left: Vec::new(), steps: Vec::new() }
    }
}

/// The surfaces in the way of a pixel's samples, in any order.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PixelSurfaces<'a, T> {
    /// Depth bits above the sample.
    pub(crate) keys: &'a [u64],
    pub(crate) opacities: &'a [T],
    /// The number of the sample that `weights` starts with.
    pub(crate) first: u32,
    /// The weights of the samples. They sum to 1 but for rounding.
    pub(crate) weights: &'a [f64],
}

impl<T: Transmittance> SurfaceSweep<T> {
    /// Passes the vertices of the weighted sum to `sink`, front to back; they are
    /// as those of
    /// [`WeightedTransmittance::run`](super::sweep::WeightedTransmittance::run),
    /// and the last one is the visibility behind everything.
    pub(crate) fn run(&mut self, pixel: &PixelSurfaces<'_, T>, sink: impl FnMut(SumVertex<T>)) {
        let PixelSurfaces { keys, opacities, first, weights } = *pixel;
        let Self { events, spare, left, steps } = self;
        events.clear();
        let event = |(hit, &key): (u32, &u64)| (key >> 32) << 32 | u64::from(hit);
        events.extend((0..).zip(keys).map(event));
        sort_by_depth(events, spare);

        left.clear();
        left.resize(weights.len(), RunningTransmittance::clear());
        steps.clear();
        steps.reserve(events.len());
        let mut settled = T::sum_from_channels(|_| f64::NEG_INFINITY);
        for &event in &*events {
            let hit = event as u32 as usize;
            let sample = (keys[hit] as u32 - first) as usize;
            let (left, weight) = (&mut left[sample], weights[sample]);
            let before = *left;
            left.block(opacities[hit]);
            let step = T::sum_from_channels(|channel| {
                weight * (left.channel(channel) - before.channel(channel))
            });
            // What is behind something opaque changes nothing.
            let changed = T::sum_from_channels(|channel| f64::from(step.as_ref()[channel] != 0.0));
            if changed != T::sum_from_channels(|_| 0.0) {
                let depth = (event >> 32) as u32;
                steps.push((depth, step));
                let z = f64::from(f32::from_bits(depth));
                settled = T::sum_from_channels(|channel| {
                    if changed.as_ref()[channel] == 0.0 { settled.as_ref()[channel] } else { z }
                });
            }
        }
        let mut last = FinalSum::<T>::new();
        for (left, &weight) in left.iter().zip(weights) {
            for channel in 0..T::CHANNELS {
                last.add(channel, weight, left.channel(channel));
            }
        }
        let end = End::<T> { value: last.value(), settled };
        draw_steps(steps.iter().copied(), &end, sink);
    }
}
