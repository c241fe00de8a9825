//! The choice of a traced map's layers.

use dsm_core::Tolerance;
use serde::{Deserialize, Serialize};

/// The choice of a map's layers, as its header keeps it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Layering {
    /// The largest number of times that a pixel's transmittance was reset to 1; 0
    /// where layers do not stand in runs.
    pub resets: u32,
    /// The largest number of layers of a pixel, at least 1.
    pub max_layers: u32,
    /// The depth of the light's centre on the camera's axis, finite and at least 0:
    /// more where the camera was moved back from it ([`LightFrame`]).
    ///
    /// [`LightFrame`]: crate::light_frame::LightFrame
    pub light_depth: f32,
}

impl Layering {
    /// The rule of the format that it breaks, if any.
    #[must_use]
    pub fn broken_rule(&self) -> Option<&'static str> {
        let is_depth = (0.0..f32::INFINITY).contains(&self.light_depth);
        (self.max_layers == 0 || !is_depth)
            .then_some("a map allows at least one layer, and its light's depth is finite and ≥ 0")
    }

    /// The rule that it breaks of a kind that keeps layers as they are, so that none
    /// is off and none begins again.
    #[must_use]
    pub fn broken_rule_of_exact(&self, tolerance: Tolerance) -> Option<&'static str> {
        let is_exact = self.resets == 0 && tolerance.epsilon() <= 0.0;
        let rule = "maps of this kind have a tolerance of 0 and no resets";
        self.broken_rule().or((!is_exact).then_some(rule))
    }
}
