//! Stratified sampling of a pixel and of the shutter's time (Lokovic & Veach 2000,
//! §3.2 and §5.5).

use crate::error::{Error, Result};
use crate::random::{WEYL, mix};

/// Bits of a random number that place a sample in its stratum.
const JITTER_BITS: u32 = 20;

/// The number of samples of a pixel, and their distribution: one in each of as many
/// strata of equal area, at a random place, and one in each of as many strata of
/// the shutter's time, at a random time.
///
/// The strata are cells in rows. A square number of samples makes a square
/// grid; of any other number some rows hold one cell more and are taller for
/// it. Which sample has which stratum of time is random, so that no direction
/// of movement meets a pattern.
///
/// All is hashed from the seed and the pixel alone: a pixel's samples are the
/// same whoever asks for them, in whatever tile, crop or order.
///
/// ```
/// use dsm_core::{PixelSampling, TileSamples};
///
/// let sampling = PixelSampling::new(5, 1)?;
/// let both = TileSamples::new(&sampling, [-1, 7], [2, 1], None)?;
/// let right = TileSamples::new(&sampling, [0, 7], [1, 1], None)?;
/// assert!(both.points().skip(5).eq(right.points()));
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct PixelSampling {
    seed: u64,
    spread: Spread,
    cells: Vec<Cell>,
}

/// Where in its stratum a sample lies, and when.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Spread {
    /// Anywhere, at a time of its own.
    Jittered,
    /// At the corner of its cell, which has no size, when the shutter is half way.
    Still,
    /// There, at one of as many times of the pixel.
    Times(u32),
}

/// A stratum of the unit square.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cell {
    min: [f64; 2],
    size: [f64; 2],
}

impl PixelSampling {
    /// The largest number of samples of a pixel.
    pub const MAX_SAMPLES: u32 = 4096;

    /// `samples` jittered samples a pixel.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] unless there are 1 to [`Self::MAX_SAMPLES`].
    pub fn new(samples: u32, seed: u64) -> Result<Self> {
        if !(1..=Self::MAX_SAMPLES).contains(&samples) {
            let reason = "must be 1 to 4096 per pixel";
            return Err(Error::Setting { setting: "samples", reason });
        }
        let rows = f64::from(samples).sqrt().round() as u32;
        let total = f64::from(samples);
        // Row r holds the cells from samples · r / rows on.
        let first = |row: u32| samples * row / rows;
        let cells = (0..rows).flat_map(|row| {
            let (start, end) = (first(row), first(row + 1));
            (start..end).map(move |index| {
                let width = f64::from(end - start).recip();
                Cell {
                    min: [f64::from(index - start) * width, f64::from(start) / total],
                    size: [width, f64::from(end - start) / total],
                }
            })
        });
        Ok(Self { seed, spread: Spread::Jittered, cells: cells.collect() })
    }

    /// One sample a pixel, through its centre when the shutter is half way.
    #[must_use]
    pub fn centre() -> Self {
        let cells = vec![Cell { min: [0.5; 2], size: [0.0; 2] }];
        Self { seed: 0, spread: Spread::Still, cells }
    }

    /// `times` samples a pixel through its centre, one in each of as many strata of the
    /// shutter's time; for one that is [`Self::centre`].
    ///
    /// # Errors
    ///
    /// As [`Self::new`].
    ///
    /// ```
    /// use dsm_core::{PixelSampling, TileSamples};
    ///
    /// let sampling = PixelSampling::centre_over_time(4, 0)?;
    /// let samples = TileSamples::new(&sampling, [3, 0], [1, 1], None)?;
    /// assert!(samples.x().iter().all(|&x| x == 3.5));
    /// let mut strata: Vec<_> = samples.times().iter().map(|time| (4.0 * time) as u32).collect();
    /// strata.sort_unstable();
    /// assert_eq!(strata, [0, 1, 2, 3]);
    /// # Ok::<(), dsm_core::Error>(())
    /// ```
    pub fn centre_over_time(times: u32, seed: u64) -> Result<Self> {
        let cells = vec![Self::centre().cells[0]; Self::new(times, seed)?.cells.len()];
        Self { cells, ..Self::centre() }.over_time(times, seed)
    }

    /// `side` × `side` samples a pixel, row by row through the centres of equal
    /// squares, when the shutter is half way: the samples of coverage masks.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] unless there are 1 to [`Self::MAX_SAMPLES`].
    ///
    /// ```
    /// use dsm_core::{PixelSampling, TileSamples};
    ///
    /// let samples = TileSamples::new(&PixelSampling::grid(2)?, [3, 0], [1, 1], None)?;
    /// assert_eq!(samples.x(), [3.25, 3.75, 3.25, 3.75]);
    /// assert_eq!(samples.y(), [0.25, 0.25, 0.75, 0.75]);
    /// # Ok::<(), dsm_core::Error>(())
    /// ```
    pub fn grid(side: u32) -> Result<Self> {
        let samples = side.saturating_mul(side);
        if !(1..=Self::MAX_SAMPLES).contains(&samples) {
            let reason = "must be 1 to 4096 per pixel";
            return Err(Error::Setting { setting: "samples", reason });
        }
        let centre = |index: u32| (f64::from(index) + 0.5) / f64::from(side);
        let cells = (0..samples)
            .map(|index| Cell { min: [centre(index % side), centre(index / side)], size: [0.0; 2] })
            .collect();
        Ok(Self { seed: 0, spread: Spread::Still, cells })
    }

    /// The same places at `times` times of each pixel, one in each of as many strata of the
    /// shutter's time. As many samples have each, or one more or less, and which is random.
    /// For one time all samples stay half way.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] unless there are 1 to as many as samples.
    pub fn over_time(self, times: u32, seed: u64) -> Result<Self> {
        if !(1..=self.samples_per_pixel()).contains(&times) {
            let reason = "must be 1 to as many as places of a pixel";
            return Err(Error::Setting { setting: "times", reason });
        }
        let spread = if times == 1 { Spread::Still } else { Spread::Times(times) };
        Ok(Self { seed, spread, ..self })
    }

    /// Samples a pixel.
    #[must_use]
    pub fn samples_per_pixel(&self) -> u32 {
        // At most MAX_SAMPLES.
        self.cells.len() as u32
    }

    /// Passes the samples of `pixel` to `sink`: x and y in (0, 1) within the pixel,
    /// and the time in [0, 1). `order` is scratch memory.
    pub(crate) fn sample(
        &self,
        pixel: [i32; 2],
        order: &mut Vec<u32>,
        mut sink: impl FnMut(f64, f64, f32),
    ) {
        if self.spread == Spread::Still {
            self.cells.iter().for_each(|cell| sink(cell.min[0], cell.min[1], 0.5));
            return;
        }
        let [x, y] = pixel.map(|coordinate| u64::from(coordinate as u32));
        let place = mix(mix(self.seed) ^ (y << 32 | x));
        let shutter = mix(place);
        shuffle(self.samples_per_pixel(), shutter, order);
        if let Spread::Times(times) = self.spread {
            let per_time = f64::from(times).recip();
            for (cell, &number) in self.cells.iter().zip(&*order) {
                let stratum = number % times;
                let bits = mix(place.wrapping_add(u64::from(stratum + 1).wrapping_mul(WEYL)));
                let time = (f64::from(stratum) + jitter(bits >> (2 * JITTER_BITS))) * per_time;
                sink(cell.min[0], cell.min[1], time as f32);
            }
            return;
        }
        let per_sample = (self.cells.len() as f64).recip();
        for ((index, cell), &stratum) in (1_u64..).zip(&self.cells).zip(&*order) {
            let bits = mix(place.wrapping_add(index.wrapping_mul(WEYL)));
            let [x, y] = [0, 1].map(|axis| {
                cell.min[axis] + cell.size[axis] * jitter(bits >> (axis as u32 * JITTER_BITS))
            });
            let time = (f64::from(stratum) + jitter(bits >> (2 * JITTER_BITS))) * per_sample;
            sink(x, y, time as f32);
        }
    }
}

/// A number in (0, 1) from the lowest bits: never an end, so that no sample
/// lies on the border of two pixels.
fn jitter(bits: u64) -> f64 {
    let steps = f64::from(1_u32 << JITTER_BITS);
    ((bits & ((1 << JITTER_BITS) - 1)) as f64 + 0.5) / steps
}

/// The numbers below `count` in random order.
fn shuffle(count: u32, seed: u64, order: &mut Vec<u32>) {
    order.clear();
    order.extend(0..count);
    for index in (1..count).rev() {
        let bits = mix(seed.wrapping_add(u64::from(index).wrapping_mul(WEYL)));
        let other = ((bits >> 32) * u64::from(index + 1)) >> 32;
        order.swap(index as usize, other as usize);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(sampling: &PixelSampling, pixel: [i32; 2]) -> Vec<(f64, f64, f32)> {
        let mut samples = Vec::new();
        sampling.sample(pixel, &mut Vec::new(), |x, y, time| samples.push((x, y, time)));
        samples
    }

    #[test]
    fn every_stratum_holds_one_sample() {
        for count in [1_u32, 2, 3, 5, 7, 16, 24, 250, 256, 1000, 4096] {
            let sampling = PixelSampling::new(count, 3).unwrap();
            let samples = samples(&sampling, [4, -9]);
            assert_eq!(samples.len() as u32, sampling.samples_per_pixel());
            let area: f64 = sampling.cells.iter().map(|cell| cell.size[0] * cell.size[1]).sum();
            assert!((area - 1.0).abs() < 1e-12);
            for (cell, &(x, y, _)) in sampling.cells.iter().zip(&samples) {
                assert!((cell.size[0] * cell.size[1] * f64::from(count) - 1.0).abs() < 1e-12);
                assert!((0.33..3.01).contains(&(cell.size[0] / cell.size[1])));
                for (axis, place) in [x, y].into_iter().enumerate() {
                    assert!(place > 0.0 && place < 1.0);
                    assert!(place > cell.min[axis] && place < cell.min[axis] + cell.size[axis]);
                }
            }
            let mut times: Vec<f32> = samples.iter().map(|&(.., time)| time).collect();
            times.sort_by(f32::total_cmp);
            for (stratum, time) in times.into_iter().enumerate() {
                assert_eq!((f64::from(time) * f64::from(count)) as usize, stratum);
            }
        }
    }

    #[test]
    fn square_numbers_make_square_grids() {
        let sampling = PixelSampling::new(16, 0).unwrap();
        assert!(sampling.cells.iter().all(|cell| cell.size == [0.25, 0.25]));
        assert_eq!(sampling.cells[6].min, [0.5, 0.25]);
    }

    #[test]
    fn seed_and_pixel_alone_decide() {
        let [one, other] = [1, 2].map(|seed| PixelSampling::new(4, seed).unwrap());
        assert_eq!(samples(&one, [3, 5]), samples(&one, [3, 5]));
        assert_ne!(samples(&one, [3, 5]), samples(&one, [5, 3]));
        assert_ne!(samples(&one, [3, 5]), samples(&one, [3, -5]));
        assert_ne!(samples(&one, [3, 5]), samples(&other, [3, 5]));
    }

    #[test]
    fn samples_are_uniform_and_independent() {
        let sampling = PixelSampling::new(1, 7).unwrap();
        let count = 100_000;
        let mut sums = [0.0; 6];
        for pixel in 0..count {
            let (x, y, time) = samples(&sampling, [pixel % 317, pixel / 317])[0];
            let values = [x - 0.5, y - 0.5, f64::from(time) - 0.5];
            for (axis, value) in values.into_iter().enumerate() {
                sums[axis] += value;
                sums[axis + 3] += value * values[(axis + 1) % 3];
            }
        }
        // Four standard deviations.
        let root = f64::from(count).sqrt();
        assert!(sums[..3].iter().all(|sum| sum.abs() < 4.0 * root / 12.0_f64.sqrt()), "{sums:?}");
        assert!(sums[3..].iter().all(|sum| sum.abs() < 4.0 * root / 12.0), "{sums:?}");
    }

    #[test]
    fn times_do_not_follow_places() {
        let sampling = PixelSampling::new(16, 2).unwrap();
        let pixels = 2000;
        let mut times = [0.0; 16];
        for pixel in 0..pixels {
            for (sum, (.., time)) in times.iter_mut().zip(samples(&sampling, [pixel, 7])) {
                *sum += f64::from(time) / f64::from(pixels);
            }
        }
        // Five standard deviations.
        let bound = 5.0 / (12.0 * f64::from(pixels)).sqrt();
        assert!(times.iter().all(|mean| (mean - 0.5).abs() < bound), "{times:?}");
    }

    #[test]
    fn places_stand_still_over_time() {
        for (times, seed) in [(2, 0), (5, 1), (16, 2), (63, 3), (64, 4)] {
            let sampling = PixelSampling::grid(8).unwrap().over_time(times, seed).unwrap();
            let still = samples(&PixelSampling::grid(8).unwrap(), [9, -2]);
            let moved = samples(&sampling, [9, -2]);
            let mut counts = vec![0_u32; times as usize];
            let mut of_stratum = vec![None; times as usize];
            for (one, other) in still.iter().zip(&moved) {
                assert_eq!((one.0, one.1), (other.0, other.1));
                let stratum = (f64::from(other.2) * f64::from(times)) as usize;
                counts[stratum] += 1;
                // One time a stratum, so that what is flat stays one fragment.
                assert_eq!(*of_stratum[stratum].get_or_insert(other.2), other.2);
            }
            let each = 64 / times;
            assert!(counts.iter().all(|&count| count == each || count == each + 1), "{counts:?}");
            assert_ne!(moved, samples(&sampling, [9, -3]));
        }
        let grid = PixelSampling::grid(8).unwrap();
        assert_eq!(grid.clone().over_time(1, 9).unwrap().spread, Spread::Still);
        assert!(grid.clone().over_time(0, 0).is_err() && grid.over_time(65, 0).is_err());
        assert!(PixelSampling::centre_over_time(0, 0).is_err());
        assert!(PixelSampling::centre_over_time(4097, 0).is_err());
    }

    #[test]
    fn neither_none_nor_too_many() {
        assert!(PixelSampling::new(0, 0).is_err());
        assert!(PixelSampling::new(4097, 0).is_err());
        assert!(PixelSampling::grid(0).is_err());
        assert!(PixelSampling::grid(65).is_err());
        assert!(PixelSampling::grid(1 << 16).is_err());
        assert_eq!(samples(&PixelSampling::centre(), [1, 2]), [(0.5, 0.5, 0.5)]);
    }
}
