//! Percentage closer filtering with the bias that filtered lookups have.

use std::convert::Infallible;
use std::sync::{Mutex, PoisonError};

use dsm_core::detail::{BiasSummary, ShadowLookup};
use dsm_core::{AreaLight, Facing, LightVisibility, ShadedPoint};
use glam::DVec3;

use super::pcf::PercentageCloserFilter;

/// Shadows of a plain shadow map for points of the world: its filter with the
/// biases of a [`ShadowLookup`], which may follow each point's slope.
///
/// ```
/// use dsm_core::detail::ShadowLookup;
/// use dsm_core::{
///     AreaLight, Error, LightVisibility, MapInfo, RayHits, RaySource, SamplePoint,
///     SurfaceHit,
/// };
/// use glam::DVec3;
/// use shadow_maps::plain::{DepthMap, DepthMapSettings, PercentageCloserFilter};
/// use shadow_maps::detail::PercentageCloserShadow;
///
/// # let to_ndc = glam::DMat4::from_cols(
/// #     glam::DVec4::new(0.5, 0.0, 0.0, 0.0),
/// #     glam::DVec4::new(0.0, -0.5, 0.0, 0.0),
/// #     glam::DVec4::new(-0.5, -0.5, -1.0, -1.0),
/// #     glam::DVec4::ZERO,
/// # );
/// # let camera = dsm_core::ShadowCamera {
/// #     world_to_camera: Some(glam::DMat4::IDENTITY),
/// #     world_to_ndc: Some(to_ndc),
/// # };
/// // An opaque wall at depth 2.
/// let source = RaySource(|_: SamplePoint, ray: &mut RayHits<f32>| -> Result<(), Error> {
///     ray.push_surface(SurfaceHit { depth: 2.0, opacity: 1.0 })
/// });
/// let mut settings = DepthMapSettings::new([32, 32], 1)?;
/// settings.camera = Some(camera);
/// let filter = PercentageCloserFilter::new(DepthMap::sample(&source, &settings)?, 16)?;
/// let info = MapInfo::new().with_camera(camera);
/// let shadow = PercentageCloserShadow::new(filter, ShadowLookup::new(&info, [32, 32])?);
/// let light = AreaLight::rectangle(DVec3::ZERO, DVec3::X * 0.5, DVec3::Y * 0.5);
/// let at = |depth: f64| shadow.visibility(DVec3::Z * -depth, &light, 0);
/// assert_eq!((at(1.0), at(3.0)), (Ok(1.0), Ok(0.0)));
/// # Ok::<(), Error>(())
/// ```
#[derive(Debug)]
pub struct PercentageCloserShadow {
    filter: PercentageCloserFilter,
    lookup: ShadowLookup,
    biases: Mutex<BiasSummary>,
}

impl PercentageCloserShadow {
    /// Shadows of `filter` with the projection and bias of `lookup`; the filter's own
    /// bias does not count.
    #[must_use]
    pub fn new(filter: PercentageCloserFilter, lookup: ShadowLookup) -> Self {
        Self { filter, lookup, biases: Mutex::default() }
    }

    /// The biases of all points so far.
    #[must_use]
    pub fn biases(&self) -> BiasSummary {
        *self.biases.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl LightVisibility for PercentageCloserShadow {
    type Value = f32;
    type Error = Infallible;

    fn visibility(&self, receiver: DVec3, light: &AreaLight, seed: u64) -> Result<f32, Infallible> {
        let point = ShadedPoint { position: receiver, facing: Facing::Light, seed };
        let mut values = Vec::with_capacity(1);
        self.visibilities(&[point], light, &mut values)?;
        Ok(values.pop().unwrap_or(1.0))
    }

    fn visibilities(
        &self,
        points: &[ShadedPoint],
        _: &AreaLight,
        values: &mut Vec<f32>,
    ) -> Result<(), Infallible> {
        let mut biases = BiasSummary::default();
        values.extend(points.iter().map(|point| match self.lookup.receiver(point, 1) {
            Some(receiver) => {
                biases.add(receiver.bias);
                self.filter.lookup(&receiver, point.seed)
            }
            None => 1.0,
        }));
        self.biases.lock().unwrap_or_else(PoisonError::into_inner).merge(biases);
        Ok(())
    }
}
