//! The JSON object of the header, with the keys of a map's kind.

use std::collections::BTreeMap;

use dsm_core::MapInfo;
use serde::{Deserialize, Serialize};

use super::deep::{Deep, DeepKeys};
use super::map_kind::MapKind;
use crate::attribute::Attribute;
use crate::error::{Error, Result};
use crate::metadata::Metadata;

/// The object as it is written.
#[derive(Serialize)]
struct Written<'a, E> {
    kind: &'a str,
    /// None: 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    kind_version: Option<u32>,
    width: u32,
    height: u32,
    channels: u8,
    #[serde(flatten)]
    info: &'a MapInfo,
    software: &'a str,
    attributes: &'a BTreeMap<String, Attribute>,
    #[serde(flatten)]
    keys: &'a E,
}

impl Metadata {
    /// The JSON object, in one fixed order of keys.
    ///
    /// # Errors
    ///
    /// [`Error::Metadata`] if the metadata breaks a rule of the format.
    pub fn to_json(&self) -> Result<Vec<u8>> {
        self.to_json_of::<Deep>(&DeepKeys {})
    }

    /// The JSON object of a map of another kind, with the kind's own keys behind
    /// those that every kind has.
    ///
    /// # Errors
    ///
    /// As [`Self::to_json`].
    pub fn to_json_of<K: MapKind>(&self, keys: &K::Keys) -> Result<Vec<u8>> {
        self.check()?;
        let Self { width, height, channels, info, software, attributes } = self;
        let written = Written {
            kind: K::NAME,
            kind_version: Some(K::version(keys)).filter(|&version| version > 1),
            width: *width,
            height: *height,
            channels: *channels,
            info,
            software,
            attributes,
            keys,
        };
        serde_json::to_vec(&written).map_err(Error::Json)
    }

    /// Reads the JSON object. Unknown keys are skipped: a later minor version
    /// may have added them.
    ///
    /// # Errors
    ///
    /// [`Error::Kind`] for another kind of map; [`Error::Metadata`] if a key
    /// is missing, has the wrong type or breaks a rule.
    pub fn from_json(json: &[u8]) -> Result<Self> {
        Self::check_kind::<Deep>(json)?;
        Self::from_json_of_any_kind(json)
    }

    /// Refuses the JSON object of another kind of map, or of a version of `K`
    /// that is not known.
    pub(crate) fn check_kind<K: MapKind>(json: &[u8]) -> Result<()> {
        // Only a map of this kind must have the other keys.
        #[derive(Deserialize)]
        struct Kind {
            kind: String,
            kind_version: Option<u32>,
        }
        let Kind { kind, kind_version } = serde_json::from_slice(json).map_err(Error::Json)?;
        if kind != K::NAME {
            return Err(Error::Kind { found: kind, wanted: K::TITLE });
        }
        match kind_version.unwrap_or(1) {
            0 => Err(Error::Metadata("the version of a kind is at least 1".to_owned())),
            version if version > K::VERSION => Err(Error::Metadata(format!(
                "version {version} of kind \"{kind}\"; this program reads up to {}",
                K::VERSION
            ))),
            _ => Ok(()),
        }
    }

    /// Refuses the JSON object of a map whose keys ask for another version of its kind than
    /// it states.
    pub(crate) fn check_version<K: MapKind>(json: &[u8], keys: &K::Keys) -> Result<()> {
        #[derive(Deserialize)]
        struct Version {
            kind_version: Option<u32>,
        }
        let Version { kind_version } = serde_json::from_slice(json).map_err(Error::Json)?;
        let (stated, needed) = (kind_version.unwrap_or(1), K::version(keys));
        if stated == needed {
            return Ok(());
        }
        Err(Error::Metadata(format!(
            "version {stated} of kind \"{}\", whose keys are those of version {needed}",
            K::NAME
        )))
    }
}
