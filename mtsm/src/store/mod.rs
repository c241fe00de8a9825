//! Layered maps in `.dsm` files: the payloads and metadata of the kinds `mtsm`,
//! `layers` and `fragments`, as `docs/format/dsm-1.md`, section 13, defines them.

pub(crate) mod bake;
pub(crate) mod fragments;
pub(crate) mod reader;
pub(crate) mod summary;
mod tile;

use serde::{Deserialize, Serialize};

use crate::multilayer_settings::Layering;

/// What the layers of a stored map are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LayeredKind {
    /// Runs of layers with counts: a [`crate::MultilayerMap`].
    Mtsm,
    /// Depths and opacities: a [`MultilayerDepthMap`](crate::MultilayerDepthMap).
    Layers,
    /// Planes with coverage masks: a [`FragmentMap`](crate::FragmentMap).
    Fragments,
}

impl LayeredKind {
    /// The kind's name in the metadata and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Mtsm => "mtsm",
            Self::Layers => "layers",
            Self::Fragments => "fragments",
        }
    }

    /// The kind of this name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        [Self::Mtsm, Self::Layers, Self::Fragments].into_iter().find(|kind| kind.name() == name)
    }
}

/// The keys of the metadata that only layered maps have.
#[derive(Serialize, Deserialize)]
struct LayeredKeys {
    layering: Layering,
    /// Places along a side of a pixel, of maps of fragments.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    coverage: Option<u32>,
}
