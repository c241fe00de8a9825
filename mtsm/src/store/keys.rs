//! Metadata keys of multilayer maps.

use dsm_io::Error;
use dsm_io::detail::Result;
use dsm_trace::detail::Layering;
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};

/// The metadata keys that multilayer maps have besides those of every map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LayeredKeys {
    /// The choice of the layers.
    pub layering: Layering,
    /// What the bound of layers left out; None for nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub left_out: Option<LeftOut>,
    /// Of fragments only, which other readers would take for layers.
    #[serde(default, skip_serializing)]
    coverage: Option<IgnoredAny>,
}

/// What a bound of layers a pixel left out: those behind the nearest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LeftOut {
    /// Pixels with more layers.
    pub pixels: u64,
    /// The most light that any pixel lets through too much behind its layers, in [0, 1].
    pub max: f32,
    /// The same in the mean over all pixels.
    pub mean: f32,
}

impl From<Layering> for LayeredKeys {
    fn from(layering: Layering) -> Self {
        Self { layering, left_out: None, coverage: None }
    }
}

impl LayeredKeys {
    /// Holds the keys of a map of kind `kind` to the format's rules.
    pub(super) fn check(&self, kind: &str) -> Result<()> {
        if self.coverage.is_some() {
            let reason = format!("a map of kind \"{kind}\" has no key \"coverage\"");
            return Err(Error::Metadata(reason));
        }
        refuse(self.layering.broken_rule())
    }
}

/// The error of a broken rule.
pub(super) fn refuse(rule: Option<&str>) -> Result<()> {
    rule.map_or(Ok(()), |rule| Err(Error::Metadata(rule.to_owned())))
}
