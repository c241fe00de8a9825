//! Settings of prefiltered maps.

use dsm_core::Error;
use dsm_core::detail::Result;

use super::accumulate::Accumulate;
use super::epsilon::Epsilon;
use super::level_plan::{LevelGeometry, LevelPlan};
use super::merge::MergedDepth;

/// How a map is filtered.
///
/// ```
/// use shadow_maps::detail::{Accumulate, PrefilterSettings};
///
/// assert_eq!(PrefilterSettings::default().accumulate, Accumulate::Multiply);
/// assert_eq!(PrefilterSettings::paper().stack_size, None);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PrefilterSettings {
    /// How near in depth fragments of a level become one.
    pub epsilon: Epsilon,
    /// The accumulation of opacities of one texel.
    pub accumulate: Accumulate,
    /// The depth of fragments that became one.
    pub depth: MergedDepth,
    /// The MIP levels end where none of their sides has more texels than this, and a
    /// stack follows (a Y-map). None: MIP levels alone.
    pub stack_size: Option<u32>,
    /// The last level. None: that whose filter covers the map.
    pub max_level: Option<u32>,
    /// Levels up to this one take one list of four as it is.
    pub subsampled: u32,
    /// Whether fragments of one texel of level 0 that lie within its ε are joined.
    pub joined: bool,
}

impl PrefilterSettings {
    /// What the paper has: ε of two widths, plain means of depths, additive, MIP levels.
    #[must_use]
    pub const fn paper() -> Self {
        Self {
            epsilon: Epsilon::PAPER,
            accumulate: Accumulate::Add,
            depth: MergedDepth::Mean,
            stack_size: None,
            max_level: None,
            subsampled: 0,
            joined: false,
        }
    }

    /// Sets the ε of merges.
    #[must_use]
    pub const fn with_epsilon(mut self, epsilon: Epsilon) -> Self {
        self.epsilon = epsilon;
        self
    }

    /// Sets the accumulation of opacities of one texel.
    #[must_use]
    pub const fn with_accumulate(mut self, accumulate: Accumulate) -> Self {
        self.accumulate = accumulate;
        self
    }

    /// Sets the size at which a stack begins; `None` for MIP levels alone.
    #[must_use]
    pub const fn with_stack_size(mut self, size: Option<u32>) -> Self {
        self.stack_size = size;
        self
    }

    /// Sets the last level; `None` for that whose filter covers the map.
    #[must_use]
    pub const fn with_max_level(mut self, level: Option<u32>) -> Self {
        self.max_level = level;
        self
    }

    /// The first level of a stack's: the last MIP level.
    fn stack_from(&self, size: [u32; 2]) -> Option<u32> {
        let most = self.stack_size?.max(1);
        let fits = |level: &u32| size.iter().all(|side| side.div_ceil(1 << level) <= most);
        (0..=LevelPlan::coarsest(size)).find(fits)
    }

    /// The levels of a map of this size, the finest first.
    ///
    /// # Errors
    ///
    /// [`Error::Level`] for a maximum that is beyond the map's
    /// coarsest level.
    pub(super) fn plan(&self, size: [u32; 2]) -> Result<(LevelPlan, Vec<LevelGeometry>)> {
        let last = self.max_level.unwrap_or_else(|| LevelPlan::coarsest(size));
        if size.iter().any(|&side| side == 0 || side > 1 << 24) {
            let reason = "a map has 1 to 2²⁴ texels a side";
            return Err(Error::Setting { setting: "size", reason });
        }
        let plan = LevelPlan { stack_from: self.stack_from(size), last, ..LevelPlan::BASE };
        let plan = LevelPlan { subsampled: self.subsampled.min(last), ..plan };
        Ok((plan, plan.geometry(size)?))
    }
}

impl Default for PrefilterSettings {
    /// What is nearest to traced rays.
    fn default() -> Self {
        Self {
            epsilon: Epsilon::INTERVAL,
            accumulate: Accumulate::Multiply,
            depth: MergedDepth::Weighted,
            stack_size: Some(128),
            ..Self::paper()
        }
    }
}
