//! Filtered shadow lookups (Lokovic & Veach 2000, §3.4):
//! V(x, y, z) = Σ wᵢⱼ Vᵢⱼ(z) / Σ wᵢⱼ over the pixels that the filter reaches.

use fearless_simd::{Level, dispatch};

use super::block::{OneByOne, Runs, weighted_average};
use super::footprint::{Ellipse, Footprint};
use super::receiver::Receiver;
use super::visibility_field::VisibilityField;
use super::weights::{Extent, Radial, Separable};
use crate::transmittance::Transmittance;

/// The visibility of `receiver`, averaged over `footprint`.
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
    let [width, height] = field.size();
    let extent = Extent([f64::from(width), f64::from(height)]);
    if !receiver.is_shaded_by(extent) {
        Ok(F::Value::CLEAR)
    } else if F::HAS_RUNS {
        dispatch!(Level::new(), simd => average(simd, field, receiver, footprint, extent))
    } else {
        average(OneByOne, field, receiver, footprint, extent)
    }
}

/// The average over `footprint` around a receiver inside the field, of which
/// `extent` lies in the map.
#[inline(always)]
pub(super) fn average<R: Runs, F: VisibilityField>(
    runs: R,
    field: &F,
    receiver: &Receiver,
    footprint: &Footprint,
    extent: Extent,
) -> Result<F::Value, F::Error> {
    let average = match *footprint {
        Footprint::Point => None,
        Footprint::Isotropic(filter) => {
            weighted_average(runs, field, receiver, Separable::new(filter, extent))?
        }
        Footprint::Elliptical { shape, axes } => {
            let ellipse = Ellipse::new(shape, axes);
            weighted_average(runs, field, receiver, Radial { ellipse, extent })?
        }
    };
    match average {
        Some(average) => Ok(average),
        // A thin ellipse may miss every pixel centre.
        None => {
            let [x, y] = receiver.position.map(|at| at as u32);
            match receiver.depth_at([receiver.offset(0, x), receiver.offset(1, y)]) {
                Some(depth) => field.evaluate([x, y], depth),
                None => Ok(F::Value::CLEAR),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::map_info::MapInfo;
    use crate::field::map::DeepMap;
    use crate::field::pixel_lists::PixelListsBuilder;
    use crate::filter::{Filter, FilterShape};
    use crate::random::next_bits;
    use crate::transmittance::Rgb;
    use crate::visibility::vertex::Vertex;

    const SIZE: [u32; 2] = [23, 9];

    /// A map that is only asked pixel by pixel.
    struct Single<'a, T>(&'a DeepMap<T>);

    impl<T: Transmittance> VisibilityField for Single<'_, T> {
        type Value = T;
        type Error = std::convert::Infallible;

        fn size(&self) -> [u32; 2] {
            self.0.size()
        }

        fn evaluate(&self, pixel: [u32; 2], depth: f32) -> Result<T, Self::Error> {
            self.0.evaluate(pixel, depth)
        }
    }

    /// Steps and ramps of 0 to 60 vertices a pixel.
    fn map<T: Transmittance>(uniform: &mut impl FnMut() -> f32) -> DeepMap<T> {
        let mut pixels = PixelListsBuilder::new(SIZE[0], SIZE[1]);
        for _ in 0..SIZE[0] * SIZE[1] {
            let (mut z, mut value) = (uniform(), T::CLEAR);
            for _ in 0..(uniform().powi(3) * 31.0) as u32 {
                pixels.push(Vertex::new(z, value));
                z += if uniform() < 0.5 { 0.0 } else { 0.2 * uniform() };
                value = T::from_channels(|channel| value.channel(channel) * uniform());
                pixels.push(Vertex::new(z, value));
                z += 0.1 * uniform() + 0.01;
            }
            pixels.finish_pixel().unwrap();
        }
        DeepMap::new(MapInfo::default(), pixels.finish().unwrap())
    }

    fn the_same_bits<T: Transmittance>(seed: u64) {
        let mut state = seed;
        let mut uniform = || (next_bits(&mut state) >> 40) as f32 / (1 << 24) as f32;
        let map = map::<T>(&mut uniform);
        let shapes = [FilterShape::Box, FilterShape::Tent, FilterShape::Gaussian];
        for round in 0..3000 {
            let shape = shapes[round % 3];
            let footprint = if round % 4 == 0 {
                let axes = [[5.0 * uniform(), uniform()], [-uniform(), 2.0 * uniform()]];
                Footprint::Elliptical { shape, axes }
            } else {
                let width = 2.0 + 18.0 * uniform().powi(2);
                Footprint::Isotropic(Filter::new(shape, width).unwrap())
            };
            let position = [uniform() * SIZE[0] as f32, uniform() * SIZE[1] as f32];
            let slope = if round % 2 == 0 { 0.0 } else { 0.4 };
            let depth_gradient = [slope * (uniform() - 0.5), slope * (uniform() - 0.5)];
            let depth = 4.0 * uniform().powi(2);
            let receiver = Receiver { depth_gradient, ..Receiver::new(position, depth) };
            // The last row and column lie partly outside, as in a level.
            let extent = Extent([22.25, 8.5]);
            let at = |level| dispatch!(level, simd => average(simd, &map, &receiver, &footprint, extent));
            let single = average(OneByOne, &Single(&map), &receiver, &footprint, extent);
            let bits = |Ok(value): Result<T, _>| {
                (0..T::CHANNELS).map(|c| value.channel(c).to_bits()).collect::<Vec<_>>()
            };
            let expected = bits(single);
            for level in [Level::new(), Level::baseline()] {
                assert_eq!(bits(at(level)), expected, "{receiver:?} {footprint:?}");
            }
        }
    }

    #[test]
    fn vectors_answer_as_single_pixels_to_the_bit() {
        the_same_bits::<f32>(1);
        the_same_bits::<Rgb>(2);
    }
}
