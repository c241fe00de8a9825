//! Metadata keys of multilayer maps.

use dsm_io::Error;
use dsm_io::detail::Result;
use dsm_trace::detail::{CutLayers, CutSum, Layering};
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};

/// The metadata keys that multilayer maps have besides those of every map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LayeredKeys {
    /// The choice of the layers.
    pub layering: Layering,
    /// What the bound of layers left out; None for nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub left_out: Option<CutLayers>,
    /// Of fragments only, which other readers would take for layers.
    #[serde(default, skip_serializing)]
    coverage: Option<IgnoredAny>,
}

impl From<Layering> for LayeredKeys {
    fn from(layering: Layering) -> Self {
        Self { layering, left_out: None, coverage: None }
    }
}

impl LayeredKeys {
    /// The keys of the map of `pixels` pixels that crops of these keys make.
    pub(super) fn join(crops: &[&Self], pixels: u64) -> std::result::Result<Self, &'static str> {
        let first = crops.first().ok_or("number")?;
        if crops.iter().any(|crop| crop.layering != first.layering) {
            return Err("layering");
        }
        let left_out = CutSum::join(crops.iter().map(|crop| crop.left_out), pixels)?;
        Ok(Self { left_out, ..**first })
    }

    /// Holds the keys of a map of kind `kind` to the format's rules.
    pub(super) fn check(&self, kind: &str) -> Result<()> {
        if self.coverage.is_some() {
            let reason = format!("a map of kind \"{kind}\" has no key \"coverage\"");
            return Err(Error::Metadata(reason));
        }
        let cut = self.left_out.and_then(|cut| cut.broken_rule());
        refuse(self.layering.broken_rule().or(cut))
    }
}

/// The error of a broken rule.
pub(super) fn refuse(rule: Option<&str>) -> Result<()> {
    rule.map_or(Ok(()), |rule| Err(Error::Metadata(rule.to_owned())))
}
