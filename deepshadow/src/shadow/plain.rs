//! Shadows of plain shadow maps.

use dsm_core::detail::ShadowLookup;
use dsm_core::{AreaLight, Bias, LightVisibility, MapInfo, ShadedPoint};
use dsm_scene::Light;
use shadow_maps::detail::PercentageCloserShadow;
use shadow_maps::plain::{DepthMap, DepthMapSettings, PercentageCloserFilter};

use super::any_visibility::AnyVisibility;
use super::handle::Shadow;
use super::statistics::ShadowStatistics;
use crate::bake::occluders::Occluders;
use crate::error::{Error, Result};
use crate::values::Values;

/// A plain shadow map and its percentage closer filter (Reeves, Salesin & Cook
/// 1987): the baseline that deep maps are compared with.
///
/// ```
/// use deepshadow::visibility::Bias;
/// use deepshadow::detail::PlainShadow;
///
/// let settings = PlainShadow::new(64).with_width(3.0).with_bias(Bias::Auto);
/// assert_eq!((settings.resolution, settings.taps), ([512, 512], 64));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PlainShadow {
    /// Width and height of the map in pixels.
    pub resolution: [u32; 2],
    /// Depths a pixel.
    pub samples: u32,
    /// Depths that are compared a point: a square number up to 4096.
    pub taps: u32,
    /// Full width of the filter in pixels.
    pub width: f32,
    /// The depth bias.
    pub bias: Bias,
}

impl PlainShadow {
    /// A map of 512 × 512 pixels with 16 depths each, and a filter of one pixel
    /// with an automatic bias.
    #[must_use]
    pub const fn new(taps: u32) -> Self {
        Self { resolution: [512; 2], samples: 16, taps, width: 1.0, bias: Bias::Auto }
    }

    /// Sets the full width of the filter in pixels.
    #[must_use]
    pub const fn with_width(mut self, width: f32) -> Self {
        self.width = width;
        self
    }

    /// Sets the depth bias.
    #[must_use]
    pub const fn with_bias(mut self, bias: Bias) -> Self {
        self.bias = bias;
        self
    }
}

/// The shadows of a plain shadow map of what `light` sees, held in memory. Mono.
///
/// # Errors
///
/// [`Error::Core`] for settings out of range; what the occluders say.
pub fn plain_shadow(
    occluders: &dyn Occluders,
    light: &Light,
    settings: &PlainShadow,
) -> Result<Shadow> {
    let PlainShadow { resolution, samples, taps, width, bias } = *settings;
    let view = light.raster(resolution)?;
    let camera = view.shadow_camera();
    let mut sampled = DepthMapSettings::new(resolution, samples)?;
    sampled.camera = Some(camera);
    let source = occluders.mono(&view)?;
    let map =
        DepthMap::sample(&source, &sampled).map_err(|error| Error::Occluders(Box::new(error)))?;
    let info = MapInfo::new().with_camera(camera);
    let lookup = ShadowLookup::new(&info, resolution)?.with_bias(bias);
    let filter = PercentageCloserFilter::new(map, taps)?.with_width(width)?;
    let shadow = Plain(PercentageCloserShadow::new(filter, lookup));
    Ok(Shadow::new(Box::new(shadow), light.area()?, 0))
}

struct Plain(PercentageCloserShadow);

impl AnyVisibility for Plain {
    fn channels(&self) -> usize {
        1
    }

    fn world(&self, points: &[ShadedPoint], light: &AreaLight, values: &mut Values) -> Result<()> {
        let mut own = Vec::with_capacity(points.len());
        let Ok(()) = self.0.visibilities(points, light, &mut own);
        values.extend(&own);
        Ok(())
    }

    fn raster(&self, _: &[[f64; 3]], _: u64, _: &AreaLight, _: &mut Values) -> Result<()> {
        Err(Error::Unsupported("a plain shadow map is queried in the world".to_owned()))
    }

    fn statistics(&self) -> ShadowStatistics {
        ShadowStatistics { biases: Some(self.0.biases()), ..ShadowStatistics::default() }
    }
}
