//! Metadata keys of maps of several views.

use dsm_io::detail::Level;
use serde::{Deserialize, Serialize};

/// The metadata keys that maps of views have besides those of every map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ViewsKeys {
    /// Where each view stands: from the map's camera, along its right, up and backward
    /// axes, in scene units. All look the same way.
    pub eyes: Vec<[f64; 3]>,
    /// How far depths of connected pixels differ at most, in sides of a pixel at the
    /// nearer one, not negative.
    pub gap: f32,
}

impl ViewsKeys {
    /// The most views.
    pub const MAX_VIEWS: usize = 1 << 10;

    /// The rule of the format that it breaks, if any.
    #[must_use]
    pub fn broken_rule(&self) -> Option<&'static str> {
        let is_sound = (1..=Self::MAX_VIEWS).contains(&self.eyes.len())
            && self.eyes.as_flattened().iter().all(|at| at.is_finite())
            && (0.0..f32::INFINITY).contains(&self.gap);
        (!is_sound).then_some(
            "a map of views has 1 to 1024 of them, at finite places, and a gap bias that is \
             finite and not negative",
        )
    }

    /// The rule that levels break, if any: there is one a view, and all have one size.
    pub(super) fn broken_rule_of_levels(&self, levels: &[Level]) -> Option<&'static str> {
        let fits = |(view, level): (usize, &Level)| {
            level.view as usize == view
                && level.number == 0
                && [level.x, level.y] == [levels[0].x, levels[0].y]
                && [level.width, level.height] == [levels[0].width, levels[0].height]
        };
        let fit = levels.len() == self.eyes.len() && levels.iter().enumerate().all(fits);
        (!fit).then_some("a map of views has one level a view, all of the same pixels")
    }
}
