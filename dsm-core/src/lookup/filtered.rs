//! Filtered shadow lookups (Lokovic & Veach 2000, §3.4):
//! V(x, y, z) = Σ wᵢⱼ Vᵢⱼ(z) / Σ wᵢⱼ over the pixels that the filter reaches.

use super::field::{RowVisitor, VisibilityField};
use super::footprint::{Ellipse, Footprint};
use crate::{Receiver, Transmittance};

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
            let scale = 2.0 / f64::from(filter.width());
            let shape = filter.shape();
            let reach = 0.5 * f64::from(filter.width());
            weighted_average(
                field,
                receiver,
                reach,
                |_| [-reach, reach],
                |row, dy| {
                    let row = cover(1, row) * shape.profile(dy * scale);
                    move |column, dx| row * (cover(0, column) * shape.profile(dx * scale))
                },
            )?
        }
        Footprint::Elliptical { shape, axes } => {
            let ellipse = &Ellipse::new(shape, axes);
            weighted_average(
                field,
                receiver,
                ellipse.height(),
                |dy| ellipse.chord(dy),
                |row, dy| {
                    let row = cover(1, row);
                    move |column, dx| row * cover(0, column) * ellipse.weight(dx, dy)
                },
            )?
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

/// The weighted average over the pixels whose centres lie within `reach` in y
/// and, for the offset of a row, within a `chord` in x, on half-open
/// intervals; `None` if all have weight 0. `row_weight` gives, for a row and
/// its offset, the weights of columns and their offsets.
#[inline(always)]
fn weighted_average<F: VisibilityField, W: Fn(u32, f64) -> f64>(
    field: &F,
    receiver: &Receiver,
    reach: f64,
    chord: impl Fn(f64) -> [f64; 2],
    row_weight: impl Fn(u32, f64) -> W,
) -> Result<Option<F::Value>, F::Error> {
    let size = field.size();
    let pixels = |axis: usize, [start, end]: [f64; 2]| {
        let centre = f64::from(receiver.position[axis]);
        let pixel = |edge: f64| ((edge - 0.5).floor() + 1.0).clamp(0.0, f64::from(size[axis]));
        pixel(centre + start) as u32..pixel(centre + end) as u32
    };
    let mut mean = WeightedMean::<F::Value>::new();
    for row in pixels(1, [-reach, reach]) {
        let dy = receiver.offset(1, row);
        let weight = row_weight(row, dy);
        let mut visitor = WeightedRow { receiver, dy, weight, asked: 0.0, mean: &mut mean };
        field.evaluate_row(row, pixels(0, chord(dy)), &mut visitor)?;
    }
    Ok(mean.finish())
}

/// Adds the pixels of a row to a mean, each with its weight.
struct WeightedRow<'a, T: Transmittance, W> {
    receiver: &'a Receiver,
    /// The row's offset from the receiver.
    dy: f64,
    weight: W,
    /// The weight of the pixel that is asked.
    asked: f64,
    mean: &'a mut WeightedMean<T>,
}

impl<T: Transmittance, W: Fn(u32, f64) -> f64> RowVisitor<T> for WeightedRow<'_, T, W> {
    #[inline(always)]
    fn depth(&mut self, column: u32) -> Option<f32> {
        let dx = self.receiver.offset(0, column);
        self.asked = (self.weight)(column, dx);
        if self.asked > 0.0 {
            let depth = self.receiver.depth_at([dx, self.dy]);
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
