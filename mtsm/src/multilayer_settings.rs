//! Settings of bakes of layered maps.

use dsm_core::detail::Result;
use dsm_core::{BakeSettings, Error, MapInfo, Tolerance};
use dsm_trace::detail::Layering;

/// Settings of a bake of a layered map: sampling, layers and resets.
///
/// ```
/// use dsm_core::{BakeSettings, PixelSampling};
/// use mtsm::MultilayerSettings;
///
/// // One ray through each pixel's centre at mid-shutter.
/// let settings = MultilayerSettings::new([512, 512])?;
/// assert_eq!(settings.bake.sampling, PixelSampling::centre());
/// assert_eq!((settings.max_layers, settings.resets), (32, 4));
/// assert_eq!(settings.tolerance().epsilon(), 0.02);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct MultilayerSettings {
    /// Size, tiles, samples, filter, tolerance and camera.
    pub bake: BakeSettings,
    /// The maximum number of resets of a pixel: its visibility starts again at 1
    /// after it has come to 0 (Xie, Tabellion & Pearce 2007, §5.1).
    pub resets: u32,
    /// The maximum number of layers of a pixel at which its visibility falls, 1 or more: the
    /// nearest are kept. The paper's maps have 5; hair needs more.
    pub max_layers: u32,
    /// The depth of the light's centre, where the camera was moved back from it
    /// (equation 4): hits up to there are dropped. Finite and at least 0.
    pub light_depth: f32,
}

impl MultilayerSettings {
    /// The default tolerance of layered maps.
    pub const TOLERANCE: f32 = 0.02;

    /// The default maximum number of layers of a pixel.
    pub const MAX_LAYERS: u32 = 32;

    /// The default maximum number of resets.
    pub const RESETS: u32 = 4;

    /// A map of `size` pixels from one ray through each pixel's centre, with 4
    /// resets and 32 layers, at a tolerance of [`Self::TOLERANCE`].
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] as [`BakeSettings::new`].
    pub fn new(size: [u32; 2]) -> Result<Self> {
        let mut bake = BakeSettings::new(size)?;
        bake.sampling = dsm_core::PixelSampling::centre();
        bake.tolerance = Some(Tolerance::new(Self::TOLERANCE)?);
        let (resets, max_layers) = (Self::RESETS, Self::MAX_LAYERS);
        Ok(Self { bake, resets, max_layers, light_depth: 0.0 })
    }

    /// The tolerance: as it was set, or [`BakeSettings::tolerance`].
    #[must_use]
    pub fn tolerance(&self) -> Tolerance {
        self.bake.tolerance()
    }

    /// What is wrong.
    pub(crate) fn check(&self) -> Result<()> {
        let refuse = |setting, reason| Err(Error::Setting { setting, reason });
        if self.bake.quantization.is_some() {
            return refuse("quantization", "layers are stored exactly");
        }
        if self.max_layers == 0 {
            return refuse("layers", "a pixel must be allowed at least 1");
        }
        if !(0.0..f32::INFINITY).contains(&self.light_depth) {
            return refuse("light depth", "it must be finite and not negative");
        }
        Ok(())
    }

    /// What a map says of itself that a bake says this of.
    pub(crate) const fn info(&self, map: MapInfo) -> LayeredInfo {
        let Self { resets, max_layers, light_depth, .. } = *self;
        let layering = Layering { resets, max_layers, light_depth };
        LayeredInfo { map, layering }
    }
}

/// The metadata of a layered map.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LayeredInfo {
    /// Camera, light, tolerance, samples, filter and windows.
    pub map: MapInfo,
    /// The choice of the layers.
    pub layering: Layering,
}
