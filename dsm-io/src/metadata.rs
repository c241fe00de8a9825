//! The metadata of a map: one JSON object in the header.

use std::collections::BTreeMap;

use dsm_core::MapInfo;
use dsm_core::detail::LightShape;
use serde::Deserialize;

use crate::attribute::Attribute;
use crate::error::{Error, Result};
use crate::metadata_text::check_text;

/// The metadata of a map: its size, channels, camera, light and free attributes.
///
/// ```
/// use dsm_io::{Attribute, Metadata};
///
/// let mut metadata = Metadata::new(640, 480, 1, dsm_core::MapInfo::default());
/// metadata.attributes.insert("owner".into(), Attribute::string("lighting"));
/// let json = metadata.to_json()?;
/// assert_eq!(Metadata::from_json(&json)?, metadata);
/// # Ok::<(), dsm_io::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Metadata {
    /// Width of level 0 in pixels.
    pub width: u32,
    /// Height of level 0 in pixels.
    pub height: u32,
    /// 1, or 3 for coloured maps.
    pub channels: u8,
    /// Camera, light, tolerance, samples, filter and windows.
    pub info: MapInfo,
    /// The program that wrote the file.
    pub software: String,
    /// Whatever else the map's maker wanted to keep, by name.
    pub attributes: BTreeMap<String, Attribute>,
}

/// The object without the map's info. That is read in a pass of its own:
/// `flatten` would take its floats through `f64`, which rounds them twice.
#[derive(Deserialize)]
struct Read {
    width: u32,
    height: u32,
    channels: u8,
    #[serde(default)]
    software: String,
    #[serde(default)]
    attributes: BTreeMap<String, Attribute>,
}

impl Metadata {
    /// The metadata of a map written by this crate, without attributes.
    #[must_use]
    pub fn new(width: u32, height: u32, channels: u8, info: MapInfo) -> Self {
        let software = concat!("dsm-io ", env!("CARGO_PKG_VERSION")).to_owned();
        Self { width, height, channels, info, software, attributes: BTreeMap::new() }
    }

    /// Reads the JSON object of a map of any kind; the keys that only that kind
    /// has are skipped.
    ///
    /// # Errors
    ///
    /// [`Error::Metadata`] as [`Self::from_json`].
    pub fn from_json_of_any_kind(json: &[u8]) -> Result<Self> {
        check_text(json)?;
        let info = serde_json::from_slice(json).map_err(Error::Json)?;
        let Read { width, height, channels, software, attributes } =
            serde_json::from_slice(json).map_err(Error::Json)?;
        let metadata = Self { width, height, channels, info, software, attributes };
        metadata.check()?;
        Ok(metadata)
    }

    /// Refuses metadata that break a rule of every kind.
    pub(crate) fn check(&self) -> Result<()> {
        let refuse = |reason: &str| Err(Error::Metadata(reason.to_owned()));
        if ![1, 3].contains(&self.channels) {
            return refuse("channels must be 1 or 3");
        }
        if self.width == 0 || self.height == 0 {
            return refuse("width and height must be at least 1");
        }
        if self.width.max(self.height) > i32::MAX as u32 {
            return refuse("width and height must be below 2³¹");
        }
        let matrices = self
            .info
            .camera
            .iter()
            .flat_map(|camera| [camera.world_to_camera, camera.world_to_ndc])
            .flatten();
        if !matrices.into_iter().all(|matrix| matrix.is_finite()) {
            return refuse("the camera's matrices must be finite");
        }
        let windows = [("data", self.info.data_window), ("display", self.info.display_window)];
        for (name, window) in windows {
            if window.is_some_and(|window| window.size().contains(&0)) {
                return Err(Error::Metadata(format!("the {name} window holds no pixel")));
            }
        }
        if self
            .info
            .light
            .is_some_and(|light| light.shape() == LightShape::Point && light.size() != [0.0; 2])
        {
            return refuse("a light that is a point has no size");
        }
        if let Some(light) = self.info.light
            && !light.size().iter().all(|size| size.is_finite() && *size >= 0.0)
        {
            return refuse("the light's size must be finite and at least 0");
        }
        if let Some(filter) = self.info.filter {
            dsm_core::Filter::new(filter.shape(), filter.width())
                .map_err(|error| Error::Metadata(error.to_string()))?;
        }
        Ok(())
    }
}
