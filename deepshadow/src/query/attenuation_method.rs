//! Lookups in attenuation maps.

/// Soft shadows by lookup in a map of kind `attenuation`: no rays, the layers of one pixel
/// or of four.
///
/// ```
/// use deepshadow::{AttenuationMethod, Query};
///
/// let query = Query::new().with_method(AttenuationMethod::new().with_bilinear(true));
/// # assert_eq!(query.method.unwrap().name(), "attenuation");
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct AttenuationMethod {
    /// How far in depth a layer may lie from a point that has its attenuation, in scene
    /// units, not negative. None: two sides of a pixel at the point.
    pub bias: Option<f64>,
    /// Whether four pixels are interpolated, against blocks in shadows that are nearer to
    /// the eye than to the light.
    pub bilinear: bool,
}

impl AttenuationMethod {
    /// One pixel, with the bias that suits the map.
    #[must_use]
    pub const fn new() -> Self {
        Self { bias: None, bilinear: false }
    }

    /// Sets the depth bias, in scene units.
    #[must_use]
    pub const fn with_bias(mut self, bias: f64) -> Self {
        self.bias = Some(bias);
        self
    }

    /// Sets whether four pixels are interpolated.
    #[must_use]
    pub const fn with_bilinear(mut self, bilinear: bool) -> Self {
        self.bilinear = bilinear;
        self
    }
}
