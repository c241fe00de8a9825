//! Filtered lookups of a map in memory, as a shadow method.

use std::sync::{Mutex, PoisonError};

use glam::DVec3;

use super::bias::BiasSummary;
use super::pyramid::Pyramid;
use super::shadow::ShadowLookup;
use super::visibility_field::VisibilityField;
use crate::light::AreaLight;
use crate::shadow::{Facing, LightVisibility, ShadedPoint};
use crate::transmittance::Transmittance;

/// A shadow method over one map that is whole in memory, by filtered lookups. The
/// light's area is not used: a map holds what one point sees.
///
/// ```
/// use dsm_core::detail::{FilteredShadow, Pyramid, ShadowLookup};
/// use dsm_core::{
///     AreaLight, DeepMap, LightVisibility, MapInfo, PixelListsBuilder, ShadowCamera,
///     Vertex,
/// };
/// use glam::{DMat4, DVec3, DVec4};
///
/// // A light at the origin that looks down −z onto one pixel, which is blocked
/// // at depth 2.
/// let ndc = DMat4::from_rows(
///     DVec4::new(0.5, 0.0, -0.5, 0.0),
///     DVec4::new(0.0, -0.5, -0.5, 0.0),
///     DVec4::NEG_Z,
///     DVec4::NEG_Z,
/// );
/// let camera = ShadowCamera { world_to_camera: Some(DMat4::IDENTITY), world_to_ndc: Some(ndc) };
/// let info = MapInfo::new().with_camera(camera);
/// let mut pixels = PixelListsBuilder::new(1, 1);
/// pixels.push(Vertex::new(2.0, 1.0));
/// pixels.push(Vertex::new(2.0, 0.25));
/// pixels.finish_pixel()?;
///
/// let lookup = ShadowLookup::new(&info, [1, 1])?;
/// let map = DeepMap::new(info, pixels.finish()?);
/// let shadow = FilteredShadow::new(Pyramid::new(vec![map])?, lookup);
/// let light = AreaLight::point(DVec3::ZERO);
/// assert_eq!(shadow.visibility(DVec3::new(0.2, 0.1, -1.0), &light, 0), Ok(1.0));
/// assert_eq!(shadow.visibility(DVec3::new(0.2, 0.1, -3.0), &light, 0), Ok(0.25));
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Debug)]
pub struct FilteredShadow<F> {
    pyramid: Pyramid<F>,
    lookup: ShadowLookup,
    biases: Mutex<BiasSummary>,
}

impl<F: VisibilityField> FilteredShadow<F> {
    /// A method that queries the levels of `pyramid` by `lookup`.
    #[must_use]
    pub fn new(pyramid: Pyramid<F>, lookup: ShadowLookup) -> Self {
        Self { pyramid, lookup, biases: Mutex::default() }
    }

    /// The biases of all points so far.
    #[must_use]
    pub fn biases(&self) -> BiasSummary {
        *self.biases.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<F: VisibilityField + Sync> LightVisibility for FilteredShadow<F> {
    type Value = F::Value;
    type Error = F::Error;

    fn visibility(
        &self,
        receiver: DVec3,
        light: &AreaLight,
        seed: u64,
    ) -> std::result::Result<F::Value, F::Error> {
        let point = ShadedPoint { position: receiver, facing: Facing::Light, seed };
        let mut values = Vec::with_capacity(1);
        self.visibilities(&[point], light, &mut values)?;
        Ok(values.pop().unwrap_or(F::Value::CLEAR))
    }

    fn visibilities(
        &self,
        points: &[ShadedPoint],
        _: &AreaLight,
        values: &mut Vec<F::Value>,
    ) -> std::result::Result<(), F::Error> {
        let biases = self.lookup.lights(&self.pyramid, points, values)?;
        self.biases.lock().unwrap_or_else(PoisonError::into_inner).merge(biases);
        Ok(())
    }
}
