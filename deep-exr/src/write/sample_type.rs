//! How written opacities are stored.

use half::f16;

use crate::channel::ChannelType;

/// Storage format of a written image's opacities; depths are 32-bit floats.
///
/// ```
/// use deep_exr::{AlphaChannels, ChannelType, SampleType, WriteOptions};
///
/// let options = WriteOptions::new(4, 4).alpha(AlphaChannels::Mono, SampleType::Half);
/// let halves = options.channels().into_iter().filter(|c| c.channel_type == ChannelType::Half);
/// assert_eq!(halves.map(|channel| channel.name).collect::<Vec<_>>(), ["A"]);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SampleType {
    /// 32-bit floats.
    #[default]
    Float,
    /// 16-bit floats: light that passes a sample is then off by up to 2⁻¹¹.
    Half,
}

impl SampleType {
    /// The largest opacity below 1.
    const fn largest_below_one(self) -> f32 {
        match self {
            Self::Float => 1.0 - f32::EPSILON / 2.0,
            Self::Half => 1.0 - 1.0 / 2048.0,
        }
    }

    /// The nearest opacity that this type holds; 1 only for 1 itself, because
    /// what is 1 lets no light through.
    ///
    /// ```
    /// use deep_exr::SampleType;
    ///
    /// assert_eq!(SampleType::Half.round(0.99999), 1.0 - 1.0 / 2048.0);
    /// assert_eq!(SampleType::Half.round(1.0), 1.0);
    /// ```
    #[must_use]
    pub fn round(self, opacity: f64) -> f32 {
        if opacity >= 1.0 {
            return 1.0;
        }
        let nearest = match self {
            Self::Float => opacity as f32,
            Self::Half => f16::from_f64(opacity).to_f32(),
        };
        nearest.min(self.largest_below_one())
    }

    pub(super) const fn channel_type(self) -> ChannelType {
        match self {
            Self::Float => ChannelType::Float,
            Self::Half => ChannelType::Half,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_lets_nothing_through_is_1() {
        for (sample_type, step) in [(SampleType::Float, 24), (SampleType::Half, 11)] {
            let below = 1.0 - 0.5_f32.powi(step);
            assert_eq!(sample_type.round(1.0), 1.0);
            assert_eq!(sample_type.round(1.0 - 1e-12), below);
            assert_eq!(sample_type.round(f64::from(below)), below);
            assert_eq!(sample_type.round(0.25), 0.25);
        }
        assert_eq!(SampleType::Half.round(0.1), f16::from_f32(0.1).to_f32());
    }
}
