//! Depth biases.

/// The depth bias: the offset towards the light that a receiver's depth is given
/// before the map is queried, so that the surface it lies on does not shade it.
///
/// ```
/// use dsm_core::detail::ShadowLookup;
/// use dsm_core::{Bias, MapInfo, Projection, View};
/// use glam::DVec3;
/// # use dsm_core::{Facing, ShadedPoint};
///
/// let view = View { eye: DVec3::Y * 5.0, target: DVec3::ZERO, up: DVec3::X };
/// let raster = view.raster(Projection::Perspective { fov: 90.0 }, [64, 64])?;
/// let info = MapInfo::new().with_camera(raster.shadow_camera());
/// let lookup = ShadowLookup::new(&info, [64, 64])?.with_bias(Bias::Depth(0.01));
/// let point = ShadedPoint { position: DVec3::ZERO, facing: Facing::Light, seed: 0 };
/// let receiver = lookup.receiver(&point, 1).unwrap();
/// assert_eq!((receiver.depth, receiver.bias), (5.0, 0.01));
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bias {
    /// A constant in scene units, for all points. All pixels under the filter are
    /// queried at one depth.
    Depth(f32),
    /// A bias from the slope of the receiver's surface or strand: the pixels under
    /// the filter are queried at the depth of its plane in each, less half of its
    /// change over the samples of a pixel, and a quarter of a pixel's side. Slopes
    /// above 16 pixel sides a pixel count as 16. Around a strand all pixels are
    /// queried at one depth, and slopes above 1.5 pixel sides a pixel count as 1.5.
    /// The bias is negative for a surface that is seen from the side that faces
    /// away from the light: it shades itself. Receivers without a surface have
    /// none.
    Auto,
}

/// Minimum, mean and maximum of the depth biases of a query's points, in scene
/// units.
///
/// ```
/// use dsm_core::detail::BiasSummary;
///
/// let mut biases = BiasSummary::default();
/// biases.add(0.25);
/// biases.add(0.75);
/// assert_eq!((biases.min, biases.mean(), biases.max), (0.25, Some(0.5), 0.75));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BiasSummary {
    /// Number of points in the map.
    pub points: u64,
    /// The smallest bias.
    pub min: f64,
    /// The sum of all biases.
    pub sum: f64,
    /// The largest bias.
    pub max: f64,
}

impl Default for BiasSummary {
    fn default() -> Self {
        Self { points: 0, min: f64::INFINITY, sum: 0.0, max: f64::NEG_INFINITY }
    }
}

impl BiasSummary {
    /// Adds the bias of a point.
    pub fn add(&mut self, bias: f32) {
        let bias = f64::from(bias);
        self.merge(Self { points: 1, min: bias, sum: bias, max: bias });
    }

    /// Adds the biases of other points.
    pub fn merge(&mut self, other: Self) {
        self.points += other.points;
        self.min = self.min.min(other.min);
        self.sum += other.sum;
        self.max = self.max.max(other.max);
    }

    /// The mean; `None` if there are no points.
    #[must_use]
    pub fn mean(&self) -> Option<f64> {
        (self.points > 0).then(|| self.sum / self.points as f64)
    }
}
