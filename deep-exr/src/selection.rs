//! The choice of what is read of a file that holds more than one thing.

use std::str::FromStr;

use crate::error::{Error, Result};

/// Part, layer and channels to read; what is `None` is chosen by what the file has.
///
/// A layer is what stands before the last dot of a channel's name. Without a choice
/// the channel `Z` is the depth, else the only one called so in a layer (in a flat
/// part also `V`, as some programs call it); its opacity is in the same layer, else
/// in the only other layer that has one.
///
/// ```
/// use deep_exr::Selection;
///
/// let beauty = Selection::default().layer("beauty");
/// assert_eq!(beauty.layer.as_deref(), Some("beauty"));
/// assert_eq!(Selection::from(Some("left")), Selection::default().part("left"));
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Selection {
    /// Name of the part.
    pub part: Option<String>,
    /// Name of the layer, without the last dot.
    pub layer: Option<String>,
    /// Names of the channels.
    pub channels: ChannelNames,
}

impl Selection {
    /// The same from the part of this name.
    #[must_use]
    pub fn part(mut self, name: impl Into<String>) -> Self {
        self.part = Some(name.into());
        self
    }

    /// The same with depth and opacity from this layer.
    #[must_use]
    pub fn layer(mut self, name: impl Into<String>) -> Self {
        self.layer = Some(name.into());
        self
    }

    /// The same with these channels, whatever their layers.
    #[must_use]
    pub fn channels(mut self, names: ChannelNames) -> Self {
        self.channels = names;
        self
    }
}

/// The part of this name.
impl From<Option<&str>> for Selection {
    fn from(part: Option<&str>) -> Self {
        Self { part: part.map(str::to_owned), ..Self::default() }
    }
}

impl From<&Selection> for Selection {
    fn from(selection: &Selection) -> Self {
        selection.clone()
    }
}

/// Names of the channels to read, as the file has them; an empty one is none.
///
/// ```
/// use deep_exr::detail::ChannelNames;
///
/// let names: ChannelNames = "Z=depth.Z,A=beauty.A".parse()?;
/// assert_eq!(names.alpha.as_deref(), Some("beauty.A"));
/// assert!("depth.Z".parse::<ChannelNames>().is_err());
/// # Ok::<(), deep_exr::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct ChannelNames {
    /// The front depth.
    pub z: Option<String>,
    /// The back depth.
    pub z_back: Option<String>,
    /// The opacity of all colours, or of those without one of their own.
    pub alpha: Option<String>,
    /// The opacities of red, green and blue.
    pub colours: [Option<String>; 3],
}

impl FromStr for ChannelNames {
    type Err = Error;

    /// Reads `Z=NAME,ZBack=NAME,A=NAME,AR=NAME,AG=NAME,AB=NAME`, any of them.
    fn from_str(text: &str) -> Result<Self> {
        let mut names = Self::default();
        for pair in text.split(',') {
            let Some((key, name)) = pair.split_once('=') else {
                return Err(Error::Selection(format!("'{pair}' is not KEY=NAME")));
            };
            let [red, green, blue] = &mut names.colours;
            let place = match key {
                "Z" => &mut names.z,
                "ZBack" => &mut names.z_back,
                "A" => &mut names.alpha,
                "AR" => red,
                "AG" => green,
                "AB" => blue,
                _ => {
                    let reason = format!("'{key}' is none of Z, ZBack, A, AR, AG and AB");
                    return Err(Error::Selection(reason));
                }
            };
            if place.replace(name.to_owned()).is_some() {
                return Err(Error::Selection(format!("'{key}' is given twice")));
            }
        }
        if names.z.as_deref() == Some("") {
            return Err(Error::Selection("Z cannot be left out".to_owned()));
        }
        Ok(names)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_one_by_one() {
        let names: ChannelNames = "AR=r,Z=a.Z,AB=b,AG=g,ZBack=".parse().unwrap();
        assert_eq!(names.colours, ["r", "g", "b"].map(|name| Some(name.to_owned())));
        assert_eq!((names.z.as_deref(), names.z_back.as_deref()), (Some("a.Z"), Some("")));
        for wrong in ["", "Z", "Q=a", "Z=a,Z=b", "Z="] {
            assert!(wrong.parse::<ChannelNames>().is_err(), "{wrong}");
        }
    }
}
