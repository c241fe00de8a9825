//! Filtered shadow lookups (Lokovic & Veach 2000, §3.4):
//! V(x, y, z) = Σ wᵢⱼ Vᵢⱼ(z) / Σ wᵢⱼ over the pixels that the filter reaches.

use std::ops::Range;

use super::field::{BlockVisitor, VisibilityField};
use super::footprint::{Ellipse, Footprint};
use crate::{Filter, Receiver, Transmittance};

/// The light that reaches `receiver`, averaged over `footprint`.
///
/// Pixels outside the field have no weight, and the rest are normalised. A
/// receiver outside the field, at a depth ≤ 0 or with a NaN is lit: 1.
/// O(p log n) for p pixels of n vertices; no allocation.
///
/// ```
/// use dsm_core::{
///     DeepMap, Filter, FilterShape, Footprint, MapInfo, PixelListsBuilder, Receiver, Vertex,
///     filtered_lookup,
/// };
///
/// // The left pixel is blocked at depth 1, the right one is clear.
/// let mut pixels = PixelListsBuilder::new(2, 1);
/// pixels.push(Vertex::new(1.0, 1.0));
/// pixels.push(Vertex::new(1.0, 0.0));
/// pixels.finish_pixel()?;
/// pixels.finish_pixel()?;
/// let map = DeepMap::new(MapInfo::default(), pixels.finish()?);
///
/// let footprint = Footprint::Isotropic(Filter::new(FilterShape::Box, 2.0)?);
/// let light = filtered_lookup(&map, &Receiver::new([1.0, 0.5], 3.0), &footprint);
/// assert_eq!(light, Ok(0.5));
/// # Ok::<(), dsm_core::Error>(())
/// ```
///
/// # Errors
///
/// The first error of `field`.
pub fn filtered_lookup<F: VisibilityField>(
    field: &F,
    receiver: &Receiver,
    footprint: &Footprint,
) -> Result<F::Value, F::Error> {
    if receiver.is_shaded_by(field.size().map(f64::from)) {
        average(field, receiver, footprint, |_, _| 1.0)
    } else {
        Ok(F::Value::CLEAR)
    }
}

/// The average over `footprint` around a receiver inside the field. `cover`
/// is the share of a pixel's side, for an axis and an index along it, that
/// lies in the map.
#[inline(always)]
pub(super) fn average<F: VisibilityField>(
    field: &F,
    receiver: &Receiver,
    footprint: &Footprint,
    cover: impl Fn(usize, u32) -> f64 + Copy,
) -> Result<F::Value, F::Error> {
    let average = match *footprint {
        Footprint::Point => None,
        Footprint::Isotropic(filter) => {
            weighted_average(field, receiver, Separable::new(filter, cover))?
        }
        Footprint::Elliptical { shape, axes } => {
            weighted_average(field, receiver, Radial { ellipse: Ellipse::new(shape, axes), cover })?
        }
    };
    match average {
        Some(average) => Ok(average),
        // A thin ellipse may miss every pixel centre.
        None => {
            let own = receiver.position.map(|at| at as u32);
            let offset = |axis: usize| receiver.offset(axis, own[axis]);
            match receiver.depth_at([offset(0), offset(1)]) {
                Some(depth) => field.evaluate(own, depth),
                None => Ok(F::Value::CLEAR),
            }
        }
    }
}

/// How the pixels around a receiver are weighted, by their offsets from it.
trait PixelWeights {
    /// Half extents of the box outside of which no pixel has a weight; its
    /// intervals are half-open.
    fn reach(&self) -> [f64; 2];

    /// The offsets in x between which the pixels of the row at `dy` can have
    /// a weight.
    fn chord(&self, dy: f64) -> [f64; 2];

    /// What all weights of the row at `dy` have in common.
    fn row(&self, row: u32, dy: f64) -> f64;

    /// The rest of a pixel's weight.
    fn pixel(&self, column: u32, offset: [f64; 2]) -> f64;
}

/// A separable filter.
struct Separable<C> {
    filter: Filter,
    /// Takes offsets to [−1, 1].
    scale: f64,
    reach: f64,
    cover: C,
}

impl<C> Separable<C> {
    fn new(filter: Filter, cover: C) -> Self {
        let width = f64::from(filter.width());
        Self { filter, scale: 2.0 / width, reach: 0.5 * width, cover }
    }
}

impl<C: Fn(usize, u32) -> f64> PixelWeights for Separable<C> {
    fn reach(&self) -> [f64; 2] {
        [self.reach; 2]
    }

    #[inline(always)]
    fn chord(&self, _: f64) -> [f64; 2] {
        [-self.reach, self.reach]
    }

    #[inline(always)]
    fn row(&self, row: u32, dy: f64) -> f64 {
        (self.cover)(1, row) * self.filter.shape().profile(dy * self.scale)
    }

    #[inline(always)]
    fn pixel(&self, column: u32, [dx, _]: [f64; 2]) -> f64 {
        (self.cover)(0, column) * self.filter.shape().profile(dx * self.scale)
    }
}

/// An ellipse.
struct Radial<C> {
    ellipse: Ellipse,
    cover: C,
}

impl<C: Fn(usize, u32) -> f64> PixelWeights for Radial<C> {
    fn reach(&self) -> [f64; 2] {
        self.ellipse.reach()
    }

    #[inline(always)]
    fn chord(&self, dy: f64) -> [f64; 2] {
        self.ellipse.chord(dy)
    }

    #[inline(always)]
    fn row(&self, row: u32, _: f64) -> f64 {
        (self.cover)(1, row)
    }

    #[inline(always)]
    fn pixel(&self, column: u32, [dx, dy]: [f64; 2]) -> f64 {
        (self.cover)(0, column) * self.ellipse.weight(dx, dy)
    }
}

/// The weighted average over the pixels that have a weight; `None` if there
/// is none.
#[inline(always)]
fn weighted_average<F: VisibilityField>(
    field: &F,
    receiver: &Receiver,
    weights: impl PixelWeights,
) -> Result<Option<F::Value>, F::Error> {
    let (size, reach) = (field.size(), weights.reach());
    let bounds =
        [0, 1].map(|axis| pixels_between(receiver, axis, [-reach[axis], reach[axis]], size[axis]));
    let mean = WeightedMean::<F::Value>::new();
    let mut block =
        WeightedBlock { receiver, weights, bounds, dy: 0.0, row: 0.0, asked: 0.0, mean };
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
struct WeightedBlock<'a, T: Transmittance, W> {
    receiver: &'a Receiver,
    weights: W,
    bounds: [Range<u32>; 2],
    /// The row's offset from the receiver.
    dy: f64,
    /// What all weights of the row have in common.
    row: f64,
    /// The weight of the pixel that is asked.
    asked: f64,
    mean: WeightedMean<T>,
}

impl<T: Transmittance, W: PixelWeights> BlockVisitor<T> for WeightedBlock<'_, T, W> {
    #[inline(always)]
    fn bounds(&self) -> [Range<u32>; 2] {
        self.bounds.clone()
    }

    #[inline(always)]
    fn columns(&mut self, row: u32) -> Range<u32> {
        self.dy = self.receiver.offset(1, row);
        self.row = self.weights.row(row, self.dy);
        let Range { start, end } = self.bounds[0];
        let chord = pixels_between(self.receiver, 0, self.weights.chord(self.dy), end);
        start.max(chord.start)..chord.end
    }

    #[inline(always)]
    fn depth(&mut self, column: u32) -> Option<f32> {
        let offset = [self.receiver.offset(0, column), self.dy];
        self.asked = self.row * self.weights.pixel(column, offset);
        if self.asked > 0.0 {
            let depth = self.receiver.depth_at(offset);
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
}

/// A weighted mean of values.
struct WeightedMean<T: Transmittance> {
    total: f64,
    sum: T::Sum,
}

impl<T: Transmittance> WeightedMean<T> {
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
    fn finish(self) -> Option<T> {
        let average = |channel: usize| (self.sum.as_ref()[channel] / self.total) as f32;
        (self.total > 0.0).then(|| T::from_channels(average))
    }
}
