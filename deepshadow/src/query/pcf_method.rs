//! Percentage closer filtering.

/// Percentage closer filtering over the outline of an area light, in a map of
/// layers.
///
/// ```
/// use deepshadow::{PcfMethod, Query};
///
/// let query = Query::new().with_method(PcfMethod::new(64).with_bias(0.01));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PcfMethod {
    /// Depths that are compared a point, 1 or more.
    pub taps: u32,
    /// The depth bias, in scene units. None: the side of a pixel at the point.
    pub bias: Option<f64>,
}

impl PcfMethod {
    /// `taps` taps, at least 1, with a bias of a pixel's side.
    #[must_use]
    pub const fn new(taps: u32) -> Self {
        Self { taps, bias: None }
    }

    /// Sets the depth bias, in scene units.
    #[must_use]
    pub const fn with_bias(mut self, bias: f64) -> Self {
        self.bias = Some(bias);
        self
    }
}
