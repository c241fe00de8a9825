//! Transmittance values, of one channel or of three.
//!
//! Every algorithm of this crate is written once over [`Transmittance`] and
//! works channel by channel, so that mono and coloured maps (Lokovic & Veach
//! 2000, §5.2) share it.

use std::fmt::Debug;

/// A coloured transmittance: the fractions of red, green and blue light, each in
/// [0, 1].
///
/// ```
/// use dsm_core::{Rgb, Transmittance};
///
/// let glass = Rgb::new(1.0, 0.5, 0.25);
/// assert_eq!(glass.channel(1), 0.5);
/// assert!(!glass.is_mono());
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rgb {
    /// Red fraction.
    pub red: f32,
    /// Green fraction.
    pub green: f32,
    /// Blue fraction.
    pub blue: f32,
}

impl Rgb {
    /// A colour from its three fractions.
    #[must_use]
    pub const fn new(red: f32, green: f32, blue: f32) -> Self {
        Self { red, green, blue }
    }
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for super::Rgb {}
}

/// A transmittance, the fraction of light that passes: `f32` for mono maps, [`Rgb`]
/// for coloured ones. Sealed: a channel count is part of the file format.
///
/// ```
/// use dsm_core::{Rgb, Transmittance};
///
/// fn through_two<T: Transmittance>(first: T, second: T) -> T {
///     T::from_channels(|index| first.channel(index) * second.channel(index))
/// }
///
/// assert_eq!(through_two(0.5_f32, 0.5), 0.25);
/// let red = Rgb::new(0.5, 0.0, 0.0);
/// assert_eq!(through_two(red, Rgb::splat(0.5)), Rgb::new(0.25, 0.0, 0.0));
/// ```
pub trait Transmittance: Copy + PartialEq + Debug + Send + Sync + sealed::Sealed + 'static {
    /// One `f64` a channel: the type of sums, slopes and bounds.
    type Sum: Copy + Debug + PartialEq + Send + Sync + AsRef<[f64]> + AsMut<[f64]> + 'static;

    /// Number of channels: 1 or 3.
    const CHANNELS: usize;

    /// Nothing in the way: 1 in every channel.
    const CLEAR: Self;

    /// All light blocked: 0 in every channel.
    const BLOCKED: Self;

    /// Builds a value channel by channel.
    fn from_channels(channel: impl FnMut(usize) -> f32) -> Self;

    /// The value of channel `index`, which is below [`Self::CHANNELS`].
    fn channel(self, index: usize) -> f32;

    /// Builds a sum channel by channel.
    fn sum_from_channels(channel: impl FnMut(usize) -> f64) -> Self::Sum;

    /// One number in every channel.
    #[must_use]
    fn splat(value: f32) -> Self {
        Self::from_channels(|_| value)
    }

    /// This value as `f64`s.
    fn to_sum(self) -> Self::Sum {
        Self::sum_from_channels(|channel| f64::from(self.channel(channel)))
    }

    /// The `f32`s nearest to `sum`.
    fn from_sum(sum: Self::Sum) -> Self {
        Self::from_channels(|channel| sum.as_ref()[channel] as f32)
    }

    /// True if all channels are equal, so that one of them stands for all.
    fn is_mono(self) -> bool {
        (1..Self::CHANNELS).all(|channel| self.channel(channel) == self.channel(0))
    }
}

impl Transmittance for f32 {
    type Sum = [f64; 1];

    const CHANNELS: usize = 1;
    const CLEAR: Self = 1.0;
    const BLOCKED: Self = 0.0;

    fn from_channels(mut channel: impl FnMut(usize) -> f32) -> Self {
        channel(0)
    }

    fn channel(self, _index: usize) -> f32 {
        self
    }

    fn sum_from_channels(mut channel: impl FnMut(usize) -> f64) -> Self::Sum {
        [channel(0)]
    }
}

impl Transmittance for Rgb {
    type Sum = [f64; 3];

    const CHANNELS: usize = 3;
    const CLEAR: Self = Self::new(1.0, 1.0, 1.0);
    const BLOCKED: Self = Self::new(0.0, 0.0, 0.0);

    fn from_channels(mut channel: impl FnMut(usize) -> f32) -> Self {
        let red = channel(0);
        let green = channel(1);
        Self::new(red, green, channel(2))
    }

    fn channel(self, index: usize) -> f32 {
        [self.red, self.green, self.blue][index]
    }

    fn sum_from_channels(channel: impl FnMut(usize) -> f64) -> Self::Sum {
        std::array::from_fn(channel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_round_trip() {
        let colour = Rgb::new(0.25, 0.5, 0.75);
        assert_eq!(Rgb::from_channels(|channel| colour.channel(channel)), colour);
        assert_eq!(Rgb::from_sum(colour.to_sum()), colour);
        assert_eq!(f32::from_sum(0.5_f32.to_sum()), 0.5);
    }

    #[test]
    fn only_equal_channels_are_mono() {
        assert!(0.3_f32.is_mono());
        assert!(Rgb::splat(0.3).is_mono());
        assert!(!Rgb::new(0.3, 0.3, 0.4).is_mono());
        assert!(!Rgb::new(0.3, 0.4, 0.3).is_mono());
    }
}
