//! Settings of a bake.

use std::collections::BTreeMap;

use dsm_core::{Compression, Filter, FilterShape, Tolerance};
use dsm_io::{Attribute, Codec, Packing, PyramidOptions};
use shadow_maps::detail::PrefilterSettings;

use crate::error::Result;
use crate::kind::Kind;

/// The channels of a map: one, or three for colours.
///
/// ```
/// use deepshadow::{Bake, Channels};
///
/// let mut settings = Bake::new([64, 64])?;
/// assert_eq!(settings.channels, Channels::Auto);
/// settings.channels = Channels::Mono;
/// # Ok::<(), deepshadow::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Channels {
    /// Three channels if any opacity has a colour, else one.
    #[default]
    Auto,
    /// One channel.
    Mono,
    /// Three channels.
    Rgb,
}

/// A bake: the kind of map, its size, and how it is sampled and stored.
///
/// What is `None` is what is usual for the kind. [`Self::check`] tells what a kind
/// does not have.
///
/// ```
/// use deepshadow::{Bake, Kind};
///
/// let settings = Bake::new([1024, 1024])?.with_kind(Kind::FRAGMENTS);
/// assert_eq!(settings.kind.name(), "fragments");
/// assert!(settings.clone().with_resets(2).check().is_err(), "runs of layers have resets");
/// # Ok::<(), deepshadow::Error>(())
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Bake {
    /// The kind of map. Default: deep.
    pub kind: Kind,
    /// Width and height in pixels.
    pub resolution: [u32; 2],
    /// Samples a pixel; of kinds `layers` and `fragments` times, all over the shutter, of the
    /// latter no more than places of a pixel. None: 16 of deep maps, the ray through the
    /// pixel's centre at mid-shutter of layered ones.
    pub samples: Option<u32>,
    /// The pixel filter. Default: a box of one pixel.
    pub filter: Filter,
    /// The bound of the error of every visibility function, of kind `fragments` of media
    /// alone. None: 0.25/√N of N samples under the filter, of kind `mtsm` 0.02, of
    /// `fragments` 0.005.
    pub tolerance: Option<Tolerance>,
    /// The maximum number of layers or fragments of a pixel: the nearest are kept.
    pub max_layers: Option<u32>,
    /// The maximum number of resets of a pixel's visibility, of kind `mtsm`.
    pub resets: Option<u32>,
    /// Places along a side of a pixel that are covered or not, of kind
    /// `fragments`: 1, 2, 4 or 8.
    pub coverage: Option<u32>,
    /// How levels are made, of kind `prefiltered`.
    pub filtering: Option<PrefilterSettings>,
    /// Points of the light that the map is made from, of kind `attenuation`. None: 64,
    /// of a point one.
    pub light_samples: Option<u32>,
    /// Views, of kind `views`. None: 4, from the light's corners, of a point one.
    pub views: Option<u32>,
    /// The channels of the map.
    pub channels: Channels,
    /// The encoding of tiles.
    pub codec: Codec,
    /// The compressor of functions, of kind `deep`. None: the usual one.
    pub compression: Option<Compression>,
    /// What depths are moved away from the light by at most, in scene units, of codec
    /// `quantized`. None: a 16,384th of the depth, and where there are strands
    /// no more than a quarter of the thinnest one's width
    /// ([`Occluders::finest_width`](crate::Occluders::finest_width)).
    pub depth_error: Option<f64>,
    /// The packing of tiles.
    pub packing: Packing,
    /// Bytes that the file may take, of kind `deep`: the smallest tolerance from
    /// [`Self::tolerance`] on for which it does is found.
    pub target_size: Option<u64>,
    /// Width and height of a tile in pixels.
    pub tile_size: u32,
    /// Mip levels that are baked as well.
    pub pyramid: Option<PyramidOptions>,
    /// The part to bake: x₀, y₀, x₁, y₁, half-open, on borders of tiles.
    pub crop: Option<[u32; 4]>,
    /// Decides with the pixel where samples lie.
    pub seed: u64,
    /// The name of the program, for the header.
    pub software: String,
    /// Other things that the header shall say.
    pub attributes: BTreeMap<String, Attribute>,
}

impl Bake {
    /// A deep map of this width and height in pixels.
    ///
    /// # Errors
    ///
    /// [`Error::Core`](crate::Error::Core) for a size of 0 or beyond 2²⁴.
    pub fn new(resolution: [u32; 2]) -> Result<Self> {
        dsm_core::BakeSettings::new(resolution)?;
        Ok(Self {
            kind: Kind::DEEP,
            resolution,
            samples: None,
            filter: Filter::new(FilterShape::Box, 1.0)?,
            tolerance: None,
            max_layers: None,
            resets: None,
            coverage: None,
            filtering: None,
            light_samples: None,
            views: None,
            channels: Channels::Auto,
            codec: Codec::Exact,
            compression: None,
            depth_error: None,
            packing: Packing::Zstd,
            target_size: None,
            tile_size: 64,
            pyramid: None,
            crop: None,
            seed: 0,
            software: concat!("deepshadow ", env!("CARGO_PKG_VERSION")).to_owned(),
            attributes: BTreeMap::new(),
        })
    }

    /// Sets the kind of map.
    #[must_use]
    pub fn with_kind(self, kind: Kind) -> Self {
        Self { kind, ..self }
    }

    /// Sets the seed.
    #[must_use]
    pub fn with_seed(self, seed: u64) -> Self {
        Self { seed, ..self }
    }

    /// Sets the samples a pixel.
    #[must_use]
    pub fn with_samples(self, samples: u32) -> Self {
        Self { samples: Some(samples), ..self }
    }

    /// Sets the bound of the error.
    #[must_use]
    pub fn with_tolerance(self, tolerance: Tolerance) -> Self {
        Self { tolerance: Some(tolerance), ..self }
    }

    /// Sets the maximum number of layers of a pixel.
    #[must_use]
    pub fn with_max_layers(self, layers: u32) -> Self {
        Self { max_layers: Some(layers), ..self }
    }

    /// Sets the maximum number of resets of visibility.
    #[must_use]
    pub fn with_resets(self, resets: u32) -> Self {
        Self { resets: Some(resets), ..self }
    }

    /// Sets the places along a side of a pixel.
    #[must_use]
    pub fn with_coverage(self, coverage: u32) -> Self {
        Self { coverage: Some(coverage), ..self }
    }

    /// Sets how levels are made, of kind `prefiltered`.
    #[must_use]
    pub fn with_filtering(self, filtering: PrefilterSettings) -> Self {
        Self { filtering: Some(filtering), ..self }
    }

    /// Sets the number of points of the light, of kind `attenuation`.
    #[must_use]
    pub fn with_light_samples(self, samples: u32) -> Self {
        Self { light_samples: Some(samples), ..self }
    }

    /// Sets the number of views, of kind `views`.
    #[must_use]
    pub fn with_views(self, views: u32) -> Self {
        Self { views: Some(views), ..self }
    }

    /// Sets the compressor of functions, of kind `deep`.
    #[must_use]
    pub fn with_compression(self, compression: Compression) -> Self {
        Self { compression: Some(compression), ..self }
    }

    /// Sets the mip levels.
    #[must_use]
    pub fn with_pyramid(self, pyramid: PyramidOptions) -> Self {
        Self { pyramid: Some(pyramid), ..self }
    }

    /// Sets the part to bake: x₀, y₀, x₁, y₁, half-open, on borders of tiles.
    #[must_use]
    pub fn with_crop(self, crop: impl Into<Option<[u32; 4]>>) -> Self {
        Self { crop: crop.into(), ..self }
    }

    /// Sets something else that the header shall say.
    #[must_use]
    pub fn with_attribute(mut self, name: &str, attribute: Attribute) -> Self {
        self.attributes.insert(name.to_owned(), attribute);
        self
    }
}
