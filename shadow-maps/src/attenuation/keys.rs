//! Metadata keys of attenuation maps.

use serde::{Deserialize, Serialize};

/// The metadata keys that attenuation maps have besides those of every map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AttenuationKeys {
    /// Points of the light that the map was made from, at least 1.
    pub light_samples: u32,
    /// How far depths of one layer differ at most, in sides of a texel there; finite and
    /// at least 0.
    pub depth_tolerance: f32,
}

impl AttenuationKeys {
    /// The rule of the format that it breaks, if any.
    #[must_use]
    pub fn broken_rule(&self) -> Option<&'static str> {
        let is_sound = (0.0..f32::INFINITY).contains(&self.depth_tolerance);
        (self.light_samples == 0 || !is_sound).then_some(
            "an attenuation map is of one point of its light or more, and its tolerance of \
             depths is finite and not negative",
        )
    }
}
