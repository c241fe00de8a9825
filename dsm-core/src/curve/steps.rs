//! Weighted sums of staircases: their final values and their vertices.

use super::compensated::RunningSum;
use crate::transmittance::Transmittance;
use crate::visibility::vertex::SumVertex;
use crate::visibility::vertex_writer::VertexWriter;

/// The final value of a weighted sum of functions. Added up from both ends: 1 − Σ w
/// (1 − τ) is exact where all are clear, Σ w τ where all are blocked.
#[derive(Clone, Copy, Debug)]
pub(super) struct FinalSum<T: Transmittance> {
    down: RunningSum<T>,
    up: RunningSum<T>,
}

impl<T: Transmittance> FinalSum<T> {
    pub(super) fn new() -> Self {
        Self { down: RunningSum::new(1.0), up: RunningSum::new(0.0) }
    }

    /// Adds a function that ends with `value` in `channel`.
    #[inline]
    pub(super) fn add(&mut self, channel: usize, weight: f64, value: f64) {
        self.down.add(channel, weight * (value - 1.0));
        self.up.add(channel, weight * value);
    }

    pub(super) fn value(&self) -> T::Sum {
        T::sum_from_channels(|channel| match self.down.channel(channel) {
            bright if bright > 0.5 => bright,
            _ => self.up.channel(channel),
        })
    }
}

/// The end of a weighted sum.
#[derive(Clone, Copy, Debug)]
pub(super) struct End<T: Transmittance> {
    pub(super) value: T::Sum,
    /// The depth where the last function reaches its final value.
    pub(super) settled: T::Sum,
}

/// Draws a sum that starts at 1 and changes by `steps`, each the bits of its
/// depth and a height, front to back.
#[inline]
pub(super) fn draw_steps<T: Transmittance>(
    steps: impl IntoIterator<Item = (u32, T::Sum)>,
    end: &End<T>,
    sink: impl FnMut(SumVertex<T>),
) {
    let mut steps = steps.into_iter();
    let mut writer = VertexWriter::<T, _>::new(sink);
    let mut value = RunningSum::<T>::new(1.0);
    let mut next = steps.next();
    while let Some((depth, step)) = next {
        (0..T::CHANNELS).for_each(|channel| value.add(channel, step.as_ref()[channel]));
        next = steps.next();
        if next.is_some_and(|(next, _)| next == depth) {
            continue;
        }
        let z = f32::from_bits(depth);
        let after = T::sum_from_channels(|channel| {
            let last = end.value.as_ref()[channel];
            if f64::from(z) >= end.settled.as_ref()[channel] {
                last
            } else {
                value.channel(channel).max(last)
            }
        });
        writer.line_to(z, writer.value());
        writer.line_to(z, after);
    }
}
