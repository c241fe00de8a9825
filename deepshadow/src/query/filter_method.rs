//! Filtered lookups.

use dsm_core::{Bias, Footprint, LevelChoice};

/// A filtered lookup: the visibility functions around a point, averaged at its
/// depth.
///
/// ```
/// use deepshadow::{FilterMethod, Query};
/// use dsm_core::{Filter, FilterShape, Footprint};
///
/// // A tent 4 pixels wide, in the mip level that fits it.
/// let tent = Filter::new(FilterShape::Tent, 4.0)?;
/// let method = FilterMethod { footprint: Footprint::Isotropic(tent), ..FilterMethod::AUTO_LEVEL };
/// let query = Query::new().with_method(method);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilterMethod {
    /// The footprint, in pixels of level 0.
    pub footprint: Footprint,
    /// The mip level that is read.
    pub level: LevelChoice,
    /// The depth bias, taken off the point's depth.
    pub bias: Bias,
}

impl FilterMethod {
    /// The pixel that contains the point, in the finest level, without a bias.
    pub const POINT: Self =
        Self { footprint: Footprint::Point, level: LevelChoice::FINEST, bias: Bias::Depth(0.0) };

    /// [`Self::POINT`] in the mip level that fits the footprint, with a bias
    /// that follows the slope of what a point lies on.
    pub const AUTO_LEVEL: Self = Self { level: LevelChoice::Auto, bias: Bias::Auto, ..Self::POINT };
}

impl Default for FilterMethod {
    fn default() -> Self {
        Self::POINT
    }
}
