//! What the metadata of maps of fragments say besides those of every map.

use dsm_trace::detail::{CutLayers, CutSum, Layering};
use serde::{Deserialize, Serialize};

/// The metadata keys that maps of fragments have besides those of every map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FragmentKeys {
    /// The bound of fragments a pixel, and the depth of the light.
    pub layering: Layering,
    /// Places along a side of a pixel that were looked at: 1, 2, 4 or 8. A file must
    /// have it.
    #[serde(default)]
    pub coverage: u32,
    /// What the bound of fragments changed; None for nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub folded: Option<CutLayers>,
    /// Media beside the fragments; None of a map without, which has version 1 of the kind's
    /// payload. With them it has version 2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub media: Option<MediaKeys>,
}

/// What the metadata say of media.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct MediaKeys {
    /// The bound of slabs a pixel, 1 or more.
    pub max_slabs: u32,
}

impl FragmentKeys {
    /// The keys of the map of `pixels` pixels that crops of these keys make.
    pub(super) fn join(crops: &[&Self], pixels: u64) -> std::result::Result<Self, &'static str> {
        let first = *crops.first().ok_or("number")?;
        let alike = |crop: &&Self| Self { folded: None, ..**crop };
        if crops.iter().any(|crop| alike(crop) != alike(&first)) {
            return Err("metadata");
        }
        let folded = CutSum::join(crops.iter().map(|crop| crop.folded), pixels)?;
        Ok(Self { folded, ..*first })
    }
}
