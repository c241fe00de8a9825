//! The weighted mean over the pixels around a receiver.

use std::ops::Range;

use fearless_simd::Simd;

use super::pixel_lists::PixelListsView;
use super::receiver::Receiver;
use super::visibility_field::{BlockVisitor, VisibilityField};
use super::weights::{PixelWeights, STRIP};
use crate::transmittance::Transmittance;

/// The weighted average over the pixels that have a weight; `None` if there
/// is none.
#[inline(always)]
pub(super) fn weighted_average<R: Runs, F: VisibilityField>(
    runs: R,
    field: &F,
    receiver: &Receiver,
    weights: impl PixelWeights,
) -> Result<Option<F::Value>, F::Error> {
    let ([width, height], [across, down]) = (field.size(), weights.reach());
    let columns = pixels_between(receiver, 0, [-across, across], width);
    let rows = pixels_between(receiver, 1, [-down, down], height);
    let mut block = WeightedBlock {
        runs,
        receiver,
        weights,
        bounds: [columns, rows],
        common_depth: receiver.common_depth(),
        dy: 0.0,
        row: 0.0,
        asked: 0.0,
        mean: WeightedMean::<F::Value>::new(),
    };
    field.evaluate_block(&mut block)?;
    Ok(block.mean.finish())
}

/// The pixels along an axis whose centres lie within half-open offsets from
/// the receiver.
#[inline(always)]
fn pixels_between(
    receiver: &Receiver,
    axis: usize,
    [start, end]: [f64; 2],
    size: u32,
) -> Range<u32> {
    let centre = f64::from(receiver.position[axis]);
    let pixel = |edge: f64| ((edge - 0.5).floor() + 1.0).clamp(0.0, f64::from(size));
    pixel(centre + start) as u32..pixel(centre + end) as u32
}

/// Adds the pixels around a receiver to a mean, each with its weight.
pub(super) struct WeightedBlock<'a, R, T: Transmittance, W> {
    runs: R,
    receiver: &'a Receiver,
    weights: W,
    bounds: [Range<u32>; 2],
    /// The depth of all pixels, if they have one.
    common_depth: Option<f32>,
    /// The row's offset from the receiver.
    dy: f64,
    /// The factor that all weights of the row share.
    row: f64,
    /// The weight of the pixel that is queried.
    asked: f64,
    mean: WeightedMean<T>,
}

impl<R: Runs, T: Transmittance, W: PixelWeights> BlockVisitor<T> for WeightedBlock<'_, R, T, W> {
    #[inline(always)]
    fn bounds(&self) -> [Range<u32>; 2] {
        self.bounds.clone()
    }

    #[inline(always)]
    fn columns(&mut self, row: u32) -> Range<u32> {
        self.dy = self.receiver.offset(1, row);
        self.row = self.weights.row(row, self.dy);
        let columns = self.bounds[0].clone();
        match self.weights.chord(self.dy) {
            None => columns,
            Some(chord) => {
                let chord = pixels_between(self.receiver, 0, chord, columns.end);
                columns.start.max(chord.start)..chord.end
            }
        }
    }

    #[inline(always)]
    fn depth(&mut self, column: u32) -> Option<f32> {
        let offset = [self.receiver.offset(0, column), self.dy];
        self.asked = self.row * self.weights.pixel(column, offset);
        if self.asked > 0.0 {
            let depth = self.common_depth.or_else(|| self.receiver.depth_at(offset));
            if depth.is_none() {
                self.take(T::CLEAR);
            }
            depth
        } else {
            None
        }
    }

    #[inline(always)]
    fn take(&mut self, value: T) {
        self.mean.add(self.asked, value);
    }

    #[inline(always)]
    fn take_run(
        &mut self,
        columns: Range<u32>,
        pixels: PixelListsView<'_, T>,
        first: usize,
    ) -> u64 {
        self.runs.take(self, columns, pixels, first)
    }
}

/// How runs of pixel lists are added to a mean: by vectors, or one by one.
pub(super) trait Runs: Copy {
    /// What [`BlockVisitor::take_run`] does.
    fn take<T: Transmittance, W: PixelWeights>(
        self,
        block: &mut WeightedBlock<'_, Self, T, W>,
        columns: Range<u32>,
        pixels: PixelListsView<'_, T>,
        first: usize,
    ) -> u64;
}

/// One by one, for fields that have no runs.
#[derive(Clone, Copy)]
pub(super) struct OneByOne;

impl Runs for OneByOne {
    #[inline(always)]
    fn take<T: Transmittance, W: PixelWeights>(
        self,
        block: &mut WeightedBlock<'_, Self, T, W>,
        columns: Range<u32>,
        pixels: PixelListsView<'_, T>,
        first: usize,
    ) -> u64 {
        let mut asked = 0;
        for (column, pixel) in columns.zip(first..) {
            if let Some(depth) = block.depth(column) {
                block.take(pixels.function(pixel).at(depth));
                asked += 1;
            }
        }
        asked
    }
}

impl<S: Simd> Runs for S {
    #[inline(always)]
    fn take<T: Transmittance, W: PixelWeights>(
        self,
        block: &mut WeightedBlock<'_, Self, T, W>,
        columns: Range<u32>,
        pixels: PixelListsView<'_, T>,
        first: usize,
    ) -> u64 {
        let at = [f64::from(block.receiver.position[0]), block.dy];
        let (mut column, mut pixel, mut asked) = (columns.start, first, 0);
        while column < columns.end {
            let count = ((columns.end - column) as usize).min(STRIP);
            let weights = block.weights.strip(self, column, count, at);
            for &weight in &weights[..count] {
                let weight = block.row * weight;
                if weight > 0.0 {
                    let offset = [block.receiver.offset(0, column), block.dy];
                    let depth = block.common_depth.or_else(|| block.receiver.depth_at(offset));
                    let value = match depth {
                        Some(depth) => {
                            asked += 1;
                            pixels.evaluate(self, pixel, depth)
                        }
                        None => T::CLEAR,
                    };
                    block.mean.add(weight, value);
                }
                (column, pixel) = (column + 1, pixel + 1);
            }
        }
        asked
    }
}

/// A weighted mean of values.
struct WeightedMean<T: Transmittance> {
    total: f64,
    sum: T::Sum,
}

impl<T: Transmittance> WeightedMean<T> {
    #[inline(always)]
    fn new() -> Self {
        Self { total: 0.0, sum: T::sum_from_channels(|_| 0.0) }
    }

    #[inline(always)]
    fn add(&mut self, weight: f64, value: T) {
        self.total += weight;
        for (channel, sum) in self.sum.as_mut().iter_mut().enumerate() {
            *sum += weight * f64::from(value.channel(channel));
        }
    }

    /// The mean; `None` if nothing with a weight was added.
    #[inline(always)]
    fn finish(self) -> Option<T> {
        let average = |channel: usize| (self.sum.as_ref()[channel] / self.total) as f32;
        (self.total > 0.0).then(|| T::from_channels(average))
    }
}
