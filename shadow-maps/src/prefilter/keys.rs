//! Metadata keys of prefiltered maps.

use dsm_core::LightExtent;
use dsm_io::detail::Level;
use dsm_trace::detail::{CutLayers, Layering};
use serde::{Deserialize, Serialize};

use super::accumulate::Accumulate;
use super::epsilon::Epsilon;
use super::level_plan::{LevelGeometry, LevelPlan};
use super::light_parts::square_width;
use super::lookup::MOST_LEVELS;
use super::merge::MergedDepth;
use super::settings::PrefilterSettings;

/// The metadata keys that prefiltered maps have besides those of every map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PrefilteredKeys {
    /// The bound of fragments a texel of level 0, and the depth of the light.
    pub layering: Layering,
    /// How levels were made.
    pub filtering: Filtering,
    /// What the bound of fragments left out; None for nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub left_out: Option<CutLayers>,
}

/// How levels were made of each other, as headers keep it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Filtering {
    /// The last MIP level: what follows is a stack. None: there is no stack.
    #[serde(default)]
    pub stack_from: Option<u32>,
    /// Levels up to this one take one list of four as it is.
    #[serde(default)]
    pub subsampled: u32,
    /// Whether fragments of one texel of level 0 that lie within its ε were joined.
    #[serde(default)]
    pub joined: bool,
    /// How near in depth fragments became one.
    pub epsilon: Epsilon,
    /// The accumulation of opacities of one texel.
    pub accumulate: Accumulate,
    /// The depth of fragments that became one.
    pub depth: MergedDepth,
}

impl Filtering {
    /// Of these settings and this plan.
    pub(super) const fn new(settings: &PrefilterSettings, plan: &LevelPlan) -> Self {
        let PrefilterSettings { epsilon, accumulate, depth, joined, .. } = *settings;
        let LevelPlan { stack_from, subsampled, .. } = *plan;
        Self { stack_from, subsampled, joined, epsilon, accumulate, depth }
    }

    /// Where the texels of a map's levels stand.
    ///
    /// # Errors
    ///
    /// The rule that the levels break.
    pub(super) fn geometry(&self, levels: &[Level]) -> Result<Vec<LevelGeometry>, &'static str> {
        let broken = Err("the levels are not those of a prefiltered map of its size");
        let count = levels.iter().take_while(|level| level.view == 0).count();
        // There is one view.
        if count == 0 || count > MOST_LEVELS || count < levels.len() {
            return broken;
        }
        let last = count as u32 - 1;
        let Self { stack_from, subsampled, .. } = *self;
        if stack_from.is_some_and(|from| from > last) && last > 0 || subsampled > last {
            return broken;
        }
        let plan = LevelPlan { stack_from, last, subsampled };
        let Ok(geometry) = plan.geometry([levels[0].width, levels[0].height]) else {
            return broken;
        };
        let fits = |(level, geometry): (&Level, &LevelGeometry)| {
            [level.width, level.height] == geometry.size && [level.x, level.y] == geometry.origin
        };
        if levels.iter().zip(&geometry).all(fits) { Ok(geometry) } else { broken }
    }
}

/// The width of the light that some choices of ε follow, in scene units.
pub(super) fn epsilon_light(light: Option<LightExtent>) -> f64 {
    light.map_or(0.0, square_width)
}
