//! Lookups in prefiltered maps.

use shadow_maps::detail::Accumulate;

/// Soft shadows by lookup in a map of kind `prefiltered`: no rays, a few lists of each
/// level.
///
/// ```
/// use deepshadow::{Accumulate, PrefilterMethod, Query};
///
/// let method = PrefilterMethod::new().with_accumulate(Accumulate::Add).with_bias(0.01);
/// let query = Query::new().with_method(method);
/// # assert!(query.method.is_some());
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct PrefilterMethod {
    /// How opacities of one list and of several levels come together. None: as when the
    /// map's levels were made.
    pub accumulate: Option<Accumulate>,
    /// The depth bias in scene units, for all points. None: of points on surfaces what
    /// lies below their tangent plane is passed over, others take the side of a texel.
    pub bias: Option<f64>,
    /// Parts along the light's shorter side, from 1 to 64: each is looked up by itself.
    /// None: 1.
    pub splits: Option<u32>,
}

impl PrefilterMethod {
    /// What suits the map.
    #[must_use]
    pub const fn new() -> Self {
        Self { accumulate: None, bias: None, splits: None }
    }

    /// Sets the accumulation.
    #[must_use]
    pub const fn with_accumulate(mut self, accumulate: Accumulate) -> Self {
        self.accumulate = Some(accumulate);
        self
    }

    /// Sets the depth bias, in scene units.
    #[must_use]
    pub const fn with_bias(mut self, bias: f64) -> Self {
        self.bias = Some(bias);
        self
    }

    /// Sets the number of parts along the light's shorter side.
    #[must_use]
    pub const fn with_splits(mut self, splits: u32) -> Self {
        self.splits = Some(splits);
        self
    }
}
