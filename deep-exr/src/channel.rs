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
    /// a colour without its own uses `A`.
    Colour,
}

/// Names of the channels that are read, as the file has them.
///
/// ```
/// use deep_exr::{AlphaChannels, DeepExrReader, DeepExrWriter, Limits, SampleType, WriteOptions};
///
/// let options = WriteOptions::new(1, 1).alpha(AlphaChannels::Mono, SampleType::Half);
/// let mut rows = options.rows(1);
/// rows.finish_pixel()?;
/// let mut writer = DeepExrWriter::new(std::io::Cursor::new(Vec::new()), &options)?;
/// writer.write_rows(&rows)?;
/// let bytes = writer.finish()?.into_inner();
/// let reader = DeepExrReader::from_bytes(bytes, None, &Limits::default())?;
/// assert_eq!((reader.header().read.z.as_str(), reader.header().read.line()), ("Z", None));
/// # Ok::<(), deep_exr::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ReadChannels {
    /// The front depth.
    pub z: String,
    /// The back depth.
    pub z_back: Option<String>,
    /// The opacity: none, one, or those of red, green and blue.
    pub opacity: Vec<String>,
}

impl ReadChannels {
    /// One line that names them, unless they are those that every image has.
    #[must_use]
    pub fn line(&self) -> Option<String> {
        let mut told = Vec::new();
        if self.z != "Z" {
            told.push(format!("depth from '{}'", self.z));
        }
        if let Some(back) = self.z_back.as_deref().filter(|&back| back != "ZBack") {
            told.push(format!("back depth from '{back}'"));
        }
        const PLAIN: [&str; 7] = ["A", "AR", "AG", "AB", "RA", "GA", "BA"];
        let is_plain = |name: &String| PLAIN.contains(&name.as_str());
        match self.opacity.as_slice() {
            [only] if only == "A" => {}
            [only] if is_plain(only) || only.rsplit('.').next() != Some("A") => {
                told.push(format!("opacity of all colours from '{only}'"));
            }
            [only] => told.push(format!("opacity from '{only}'")),
            several if several.iter().all(is_plain) => {}
            several => told.push(format!("opacity from '{}'", several.join("', '"))),
        }
        (!told.is_empty()).then(|| told.join(", "))
    }

    /// Whether a channel of this name is read.
    #[must_use]
    pub fn contains(&self, name: &str) -> bool {
        let read = [&self.z].into_iter().chain(&self.z_back).chain(&self.opacity);
        read.into_iter().any(|own| own == name)
    }
}
