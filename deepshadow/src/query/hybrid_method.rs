//! Short rays, and lookups beyond.

use super::prefilter_method::PrefilterMethod;

/// Soft shadows by short rays near a receiver, through a scene or a map of kind
/// `fragments`, times lookups in a map of kind `prefiltered` beyond.
///
/// ```
/// use deepshadow::{HybridMethod, Query};
///
/// let query = Query::new().with_method(HybridMethod::new(16));
/// # assert_eq!(query.method.unwrap().name(), "hybrid");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct HybridMethod {
    /// Short rays of a receiver, at least 1: of each part of the light the nearest square
    /// number. Where the map shows nothing near, none are traced.
    pub rays: u32,
    /// How far they go: to where the light's cone is so many texels of the finest level
    /// wide. None: 8.
    pub reach: Option<f64>,
    /// The lookups beyond.
    pub lookup: PrefilterMethod,
}

impl HybridMethod {
    /// `rays` short rays, with what suits the map.
    #[must_use]
    pub const fn new(rays: u32) -> Self {
        Self { rays, reach: None, lookup: PrefilterMethod::new() }
    }

    /// Sets how far short rays go, in texels of the finest level.
    #[must_use]
    pub const fn with_reach(mut self, texels: f64) -> Self {
        self.reach = Some(texels);
        self
    }

    /// Sets the lookups beyond.
    #[must_use]
    pub const fn with_lookup(mut self, lookup: PrefilterMethod) -> Self {
        self.lookup = lookup;
        self
    }
}

impl Default for HybridMethod {
    /// 16 rays.
    fn default() -> Self {
        Self::new(16)
    }
}
