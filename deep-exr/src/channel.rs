//! What a part's channels are called, and how they store their values.

/// Storage format of a channel's values.
///
/// ```
/// use deep_exr::{AlphaChannels, ChannelType, SampleType, WriteOptions};
///
/// let options = WriteOptions::new(4, 4).alpha(AlphaChannels::Mono, SampleType::Half);
/// let types = |name: &str| {
///     let channels = options.channels();
///     channels.into_iter().find(|channel| channel.name == name).map(|channel| channel.channel_type)
/// };
/// assert_eq!([types("A"), types("Z")], [Some(ChannelType::Half), Some(ChannelType::Float)]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChannelType {
    /// 16-bit floats.
    Half,
    /// 32-bit floats.
    Float,
    /// 32-bit unsigned integers.
    Uint,
}

impl ChannelType {
    /// 16-bit words of one value.
    pub(super) fn words(self) -> usize {
        match self {
            Self::Half => 1,
            Self::Float | Self::Uint => 2,
        }
    }
}

/// A channel of a part: its name and its storage format.
///
/// ```
/// use deep_exr::{AlphaChannels, ChannelType, SampleType, WriteOptions};
///
/// let options = WriteOptions::new(4, 4).alpha(AlphaChannels::Mono, SampleType::Half);
/// let channels = options.channels();
/// let opacity = channels.iter().find(|channel| channel.name == "A");
/// assert_eq!(opacity.map(|channel| channel.channel_type), Some(ChannelType::Half));
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Its name, such as `Z` or `AR`.
    pub name: String,
    /// Storage format of its values.
    pub channel_type: ChannelType,
}

/// Channels that hold the samples' opacity.
///
/// ```
/// use deep_exr::{AlphaChannels, DeepRows};
///
/// let rows = DeepRows::new(1, AlphaChannels::Colour, false);
/// assert_eq!(rows.alpha_channels(), AlphaChannels::Colour);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AlphaChannels {
    /// There is no alpha channel: every sample is opaque.
    None,
    /// One opacity, from `A`.
    Mono,
    /// One opacity per colour, from `AR`, `AG`, `AB` (or `RA`, `GA`, `BA`);
    /// a colour without its own uses `A`, and is opaque without that.
    Colour,
}
