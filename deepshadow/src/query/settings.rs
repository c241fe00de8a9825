//! Settings of queries.

use dsm_core::AreaLight;

use super::method::Method;

/// A query of a map: its method, its light and its seed.
///
/// Everything has a default, so that `Query::new()` queries each kind of map in
/// its own way: deep maps are filtered at the pixel that contains the point, prefiltered
/// ones looked up, all others traced with 256 rays to the light of their header.
///
/// ```
/// use deepshadow::{Query, TraceMethod};
///
/// let query = Query::new().with_method(TraceMethod::new(64)).with_light_size([0.5, 0.5]);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Query {
    /// The method. None: that of the map's kind.
    pub method: Option<Method>,
    /// The light, in the world. None: that of the map's header.
    pub light: Option<AreaLight>,
    /// Full width and height of the header's light in its place, in scene units.
    pub light_size: Option<[f32; 2]>,
    /// The seed of methods that sample.
    pub seed: u64,
}

impl Query {
    /// A query with all defaults.
    #[must_use]
    pub const fn new() -> Self {
        Self { method: None, light: None, light_size: None, seed: 0 }
    }

    /// Sets the method.
    #[must_use]
    pub fn with_method(self, method: impl Into<Method>) -> Self {
        Self { method: Some(method.into()), ..self }
    }

    /// Sets the light, wherever it stands.
    #[must_use]
    pub const fn with_light(mut self, light: AreaLight) -> Self {
        self.light = Some(light);
        self
    }

    /// Sets the full width and height of the header's light, in scene units: of a
    /// disk or a sphere the diameter. Nothing of any size is a point, and a point
    /// of some size a rectangle.
    #[must_use]
    pub const fn with_light_size(mut self, size: [f32; 2]) -> Self {
        self.light_size = Some(size);
        self
    }

    /// Sets the seed.
    #[must_use]
    pub const fn with_seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }
}
