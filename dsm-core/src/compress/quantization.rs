//! Quantization of functions to grids, for small files.

use super::side::Side;
use crate::error::{Error, Result};
use crate::tolerance::Tolerance;
use crate::transmittance::Transmittance;
use crate::visibility::vertex::Vertex;

/// Bits of an `f32` behind the point.
const MANTISSA: u32 = f32::MANTISSA_DIGITS - 1;

/// The grids that the vertices of a map are rounded to.
///
/// Depths keep some bits behind the point of their binary floating
/// representation: they are moved away from the light by less than z · 2⁻ᵇ for b
/// bits, or by less than a depth error in scene units, and what comes to lie at one
/// depth becomes one step. Values become
/// multiples of a power of two, [`Self::value_step`], and so does the last. Both
/// happen behind compression, which leaves room for the rounding of values. What
/// is clear or opaque stays
/// exactly so. With δ the largest move of a depth, V′ keeps
///
/// V(z) − ε ≤ V′(z) ≤ V(z − δ) + ε,
///
/// the left limit on the right-hand side at a step.
///
/// ```
/// use dsm_core::detail::Quantization;
/// use dsm_core::Tolerance;
///
/// let quantization = Quantization::new(4)?;
/// assert_eq!(quantization.snap(1.0), 1.0);
/// assert_eq!(quantization.snap(1.01), 1.0625);
/// // Where 4 bits are too coarse, as many more as it takes.
/// assert_eq!(quantization.with_depth_error(0.01)?.snap(1.01), 1.015625);
/// assert_eq!(Quantization::value_step(Tolerance::new(0.0625)?), 1.0 / 64.0);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quantization {
    depth_bits: u32,
    /// The exponent of the grid's largest step, a power of two; none for any.
    step: Option<i32>,
}

impl Default for Quantization {
    /// Depths with 14 bits behind the point: moved by less than a 16,000th.
    fn default() -> Self {
        Self { depth_bits: 14, step: None }
    }
}

impl Quantization {
    /// The smallest tolerance whose values can be rounded.
    pub const MIN_TOLERANCE: f32 = 1.0 / (1 << 16) as f32;

    /// Depths with this many bits behind the point.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] unless there are 4 to 23, which keep them as they
    /// are.
    pub fn new(depth_bits: u32) -> Result<Self> {
        if (4..=MANTISSA).contains(&depth_bits) {
            Ok(Self { depth_bits, step: None })
        } else {
            let reason = "depths keep 4 to 23 bits";
            Err(Error::Setting { setting: "quantization", reason })
        }
    }

    /// Depths that are moved by less than `error` scene units, whatever the bits that
    /// takes.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] unless `error` is finite and above 0.
    pub fn within(error: f64) -> Result<Self> {
        Self { depth_bits: 0, step: None }.with_depth_error(error)
    }

    /// The same, and no depth is moved by `error` scene units or more: what is coarser
    /// keeps more bits. All of them where `error` is less than what an `f32` can tell
    /// apart.
    ///
    /// # Errors
    ///
    /// As [`Self::within`].
    pub fn with_depth_error(self, error: f64) -> Result<Self> {
        if !(error > 0.0 && error.is_finite()) {
            let reason = "a depth error has to be above 0";
            return Err(Error::Setting { setting: "quantization", reason });
        }
        // That of the largest power of two that is not above it, by its bits; below
        // the normal numbers it is finer than any depth.
        let step = (error.to_bits() >> 52) as i32 - 1023;
        Ok(Self { step: Some(self.step.map_or(step, |own| own.min(step))), ..self })
    }

    /// Bits of a depth behind the point.
    pub(super) fn bits(self, z: f32) -> u32 {
        let exponent = (z.to_bits() >> MANTISSA) as i32 - 127;
        let needed = self.step.map_or(0, |step| (exponent - step).clamp(0, MANTISSA as i32));
        self.depth_bits.max(needed as u32)
    }

    /// The nearest depth of the grid that is not nearer to the light; the
    /// largest there is for what would be infinite. `z` is finite and ≥ 0.
    #[must_use]
    pub fn snap(self, z: f32) -> f32 {
        let below = (1 << (MANTISSA - self.bits(z))) - 1;
        // Numbers of one sign are in the order of their bits.
        let up = f32::from_bits((z.to_bits() + below) & !below);
        if up.is_finite() { up } else { f32::from_bits(f32::MAX.to_bits() & !below).max(z) }
    }

    /// The grid of values: the largest power of two that is at most a quarter
    /// of ε.
    #[must_use]
    pub fn value_step(tolerance: Tolerance) -> f32 {
        let quarter = 0.25 * tolerance.epsilon().max(Self::MIN_TOLERANCE);
        // Its bits without the mantissa.
        f32::from_bits(quarter.to_bits() & !((1 << MANTISSA) - 1))
    }

    /// The tolerance that is left for compression: half a step less, or a whole one
    /// where values are rounded to one side.
    pub(crate) fn rest(tolerance: Tolerance, side: Side) -> Tolerance {
        let steps = if side == Side::Both { 0.5 } else { 1.0 };
        tolerance.after(steps * f64::from(Self::value_step(tolerance)))
    }

    /// Moves the vertices that `vertices` hold from `start` on to the grid of
    /// depths. Of those that share a depth then, the first and the last stay: a
    /// step. Returns how far one was moved at most, not rounded down.
    ///
    /// Behind compression, not before it: many small falls within one step of
    /// the grid would become a large one, which no ramp could stand for.
    pub(crate) fn snap_depths<T: Transmittance>(
        self,
        vertices: &mut Vec<Vertex<T>>,
        start: usize,
    ) -> f32 {
        let (mut kept, mut farthest) = (start, 0.0_f64);
        for index in start..vertices.len() {
            let Vertex { z, value } = vertices[index];
            let snapped = self.snap(z);
            farthest = farthest.max(f64::from(snapped) - f64::from(z));
            let is_third = kept >= start + 2
                && vertices[kept - 2..kept].iter().all(|vertex| vertex.z == snapped);
            kept -= usize::from(is_third);
            vertices[kept] = Vertex::new(snapped, value);
            kept += 1;
        }
        vertices.truncate(kept);
        let nearest = farthest as f32;
        if f64::from(nearest) < farthest { nearest.next_up() } else { nearest }
    }

    /// Rounds the values of the function that `vertices` hold from `start` on, to this
    /// side, and drops what says nothing then.
    pub(crate) fn round_values<T: Transmittance>(
        tolerance: Tolerance,
        side: Side,
        vertices: &mut Vec<Vertex<T>>,
        start: usize,
    ) {
        let round = match side {
            Side::Both => f32::round,
            Side::Lighter => f32::ceil,
            Side::Darker => f32::floor,
        };
        let step = Self::value_step(tolerance);
        let mut kept = start;
        for index in start..vertices.len() {
            let Vertex { z, value } = vertices[index];
            // A power of two: both operations are exact, so the result is a
            // multiple.
            let value = T::from_channels(|channel| round(value.channel(channel) / step) * step);
            let rounded = Vertex::new(z, value);
            if kept == start || vertices[kept - 1] != rounded {
                vertices[kept] = rounded;
                kept += 1;
            }
        }
        vertices.truncate(kept);
        if vertices.last().is_some_and(|last| last.value == T::CLEAR) {
            vertices.truncate(start);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depths_move_away_and_no_further() {
        for bits in [4, 9, 14, 23] {
            let quantization = Quantization::new(bits).unwrap();
            let relative = 0.5_f64.powi(bits as i32);
            for step in 0..5000_u16 {
                let z = 0.01 * f32::from(step) * f32::from(step) * 1.000_1;
                let snapped = quantization.snap(z);
                assert!(
                    snapped >= z
                        && f64::from(snapped) - f64::from(z) < relative * f64::from(z).max(1e-30)
                );
                assert_eq!(quantization.snap(snapped), snapped);
            }
            let last = quantization.snap(f32::MAX);
            assert!(last.is_finite() && last == f32::MAX);
        }
        assert!(Quantization::new(3).is_err());
        assert!(Quantization::new(24).is_err());
    }

    #[test]
    fn depths_move_by_less_than_the_error_that_is_allowed() {
        for error in [1e-30, 1e-3, 0.25, 1.0, 3.0, 1e6] {
            let within = Quantization::within(error).unwrap();
            let both = Quantization::default().with_depth_error(error).unwrap();
            let finer = both.with_depth_error(0.5 * error).unwrap();
            let mut before = 0.0_f32;
            for step in 0..5000_u16 {
                let z = 0.01 * f32::from(step) * f32::from(step) * 1.000_1;
                let moved = |snapped: f32| f64::from(snapped) - f64::from(z);
                let snapped = within.snap(z);
                assert!(snapped >= z && moved(snapped) < error, "{z} {snapped} {error}");
                assert_eq!(within.snap(snapped), snapped);
                assert!(snapped >= before, "depths keep their order");
                before = snapped;
                let usual = Quantization::default().snap(z);
                assert_eq!(moved(both.snap(z)).min(moved(usual)), moved(both.snap(z)));
                assert!(moved(finer.snap(z)) < 0.5 * error);
            }
        }
        // No finer than it has to be: a file needs fewer bits then.
        assert_eq!(Quantization::within(0.25).unwrap().snap(1000.1), 1000.25);
        assert_eq!(Quantization::within(0.3).unwrap().snap(1000.3), 1000.5);
        for error in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Quantization::within(error).is_err());
        }
    }

    #[test]
    fn what_shares_a_depth_is_a_step() {
        let quantization = Quantization::new(4).unwrap();
        let vertices = |vertices: &[(f32, f32)]| -> Vec<Vertex<f32>> {
            vertices.iter().map(|&(z, value)| Vertex::new(z, value)).collect()
        };
        let fall = [(1.0, 1.0), (1.01, 1.0), (1.01, 0.75), (1.02, 0.75), (1.06, 0.25), (3.0, 0.25)];
        let mut snapped = [vertices(&[(9.0, 0.5)]), vertices(&fall)].concat();
        let moved = quantization.snap_depths(&mut snapped, 1);
        let after = [(9.0, 0.5), (1.0, 1.0), (1.0625, 1.0), (1.0625, 0.25), (3.0, 0.25)];
        assert_eq!(snapped, vertices(&after));
        assert!((moved - 0.0525).abs() < 1e-6, "{moved}");
    }

    #[test]
    fn values_are_rounded_and_the_clear_is_nothing() {
        let tolerance = Tolerance::new(0.0625).unwrap();
        let round = |values: &[(f32, f32)]| {
            let mut vertices = vec![Vertex::new(7.0, 0.3)];
            vertices.extend(values.iter().map(|&(z, value)| Vertex::new(z, value)));
            Quantization::round_values(tolerance, Side::Both, &mut vertices, 1);
            vertices.iter().skip(1).map(|vertex| (vertex.z, vertex.value)).collect::<Vec<_>>()
        };
        assert_eq!(round(&[(1.0, 1.0), (1.0, 0.999), (2.0, 0.5)]), [(1.0, 1.0), (2.0, 0.5)]);
        assert_eq!(round(&[(1.0, 1.0), (1.0, 0.51)]), [(1.0, 1.0), (1.0, 33.0 / 64.0)]);
        assert_eq!(round(&[(1.0, 1.0), (2.0, 0.999)]), []);
    }

    #[test]
    fn steps_are_powers_of_two() {
        for epsilon in [0.9, 0.25, 0.0625, 0.004, 1e-4, 1.0 / 65536.0] {
            let tolerance = Tolerance::new(epsilon).unwrap();
            let step = Quantization::value_step(tolerance);
            assert_eq!(step.to_bits() & 0x7f_ffff, 0);
            assert!(step <= 0.25 * epsilon && step > 0.125 * epsilon);
            assert!(Quantization::rest(tolerance, Side::Both).epsilon() >= 0.87 * epsilon);
        }
    }
}
