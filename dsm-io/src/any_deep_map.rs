//! Deep maps whose number of channels is decided at run time.

use dsm_core::{DeepMap, MapInfo, Rgb};

/// A deep map of either number of channels.
///
/// ```no_run
/// use dsm_io::detail::AnyDeepMap;
/// use dsm_io::{Limits, MapReader};
///
/// let reader = MapReader::open("shadow.dsm", &Limits::default())?;
/// match AnyDeepMap::read(&reader, 0)? {
///     AnyDeepMap::Mono(map) => println!("{}", map.pixel(0, 0).at(4.5)),
///     AnyDeepMap::Rgb(map) => println!("{:?}", map.pixel(0, 0).at(4.5)),
/// }
/// # Ok::<(), dsm_io::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub enum AnyDeepMap {
    /// One channel.
    Mono(DeepMap<f32>),
    /// Three channels.
    Rgb(DeepMap<Rgb>),
}

impl AnyDeepMap {
    /// Number of channels: 1 or 3.
    #[must_use]
    pub const fn channels(&self) -> u8 {
        match self {
            Self::Mono(_) => 1,
            Self::Rgb(_) => 3,
        }
    }

    /// The map's camera, light, tolerance, samples, filter and windows.
    #[must_use]
    pub const fn info(&self) -> &MapInfo {
        match self {
            Self::Mono(map) => map.info(),
            Self::Rgb(map) => map.info(),
        }
    }
}

impl From<DeepMap<f32>> for AnyDeepMap {
    fn from(map: DeepMap<f32>) -> Self {
        Self::Mono(map)
    }
}

impl From<DeepMap<Rgb>> for AnyDeepMap {
    fn from(map: DeepMap<Rgb>) -> Self {
        Self::Rgb(map)
    }
}
