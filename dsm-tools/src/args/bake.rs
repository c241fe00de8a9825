//! The switches of `bake`.

use std::path::PathBuf;

use clap::builder::RangedU64ValueParser;
use clap::{Args, ValueEnum};
use dsm_core::{BakeSettings, Filter, FilterShape, PixelSampling, Quantization, Tolerance};
use dsm_io::{BakeOptions, PyramidOptions};
use mtsm::{LayeredKind, MultilayerSettings};

use super::values::{self, Effort};

const EXAMPLES: &str = "\
Examples:
  dsm-tools bake builtin:hairball -o hair.dsm
  dsm-tools bake scene.toml -o map.dsm --resolution 2048 --samples 64 --mip
  dsm-tools bake scene.toml -o left.dsm --resolution 512 --crop 0,0,256,512
  dsm-tools bake model.obj -o layers.dsm --kind layers";

/// Bakes the shadow map of a scene's light
///
/// SCENE is a scene file (.toml), a model (.obj, .ply, .gltf, .glb, .hair,
/// .vdb) that is looked at from a light of its own, or builtin:NAME.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct BakeFlags {
    /// A scene file, a model, or builtin:NAME
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// The map to write
    #[arg(short, long = "output", value_name = "MAP.dsm", value_parser = values::dsm_file())]
    output: PathBuf,
    /// What kind of map
    #[arg(long, value_enum, default_value = "deep")]
    kind: KindName,
    /// Width and height of the map in pixels; one number: a square
    #[arg(long, value_name = "W[xH]", default_value = "512", value_parser = values::resolution)]
    resolution: [u32; 2],
    /// Samples a pixel [default: 16; of layered maps 1, the ray through the
    /// pixel's centre at mid-shutter]
    #[arg(long, value_name = "N")]
    #[arg(value_parser = RangedU64ValueParser::<u32>::new().range(1..=4096))]
    samples: Option<u32>,
    /// The pixel filter
    #[arg(long, value_enum, default_value = "box")]
    filter: ShapeName,
    /// The full width of the pixel filter, in pixels [default: 1, of a tent 2]
    #[arg(long, value_name = "PIXELS", value_parser = values::finite)]
    filter_width: Option<f32>,
    /// How far the light may be off at any depth, in [0, 1); auto is
    /// 0.25/√N for the N samples under the filter, of kind mtsm 0.02
    #[arg(long, value_name = "auto|E", default_value = "auto", allow_negative_numbers = true)]
    #[arg(value_parser = values::auto_tolerance)]
    tolerance: values::AutoTolerance,
    /// The most layers of a pixel, of kinds layers and mtsm [default: 32]
    #[arg(long, value_name = "K")]
    #[arg(value_parser = RangedU64ValueParser::<u32>::new().range(1..=1 << 20))]
    layers: Option<u32>,
    /// Places along a side of a pixel that are looked at, of kind layers: its
    /// layers are pieces of planes with masks; of 1: hits at pixel centres
    /// [default: 8]
    #[arg(long, value_name = "1|2|4|8", value_parser = coverage)]
    coverage: Option<u32>,
    /// How often the light left in a pixel is set to 1 again after it has come
    /// to 0, of kind mtsm [default: 4]
    #[arg(long, value_name = "R")]
    #[arg(value_parser = RangedU64ValueParser::<u32>::new().range(0..=1 << 20))]
    resets: Option<u32>,
    /// Whether the light has a colour; auto: if anything in the scene has
    #[arg(long, value_enum, default_value = "auto")]
    channels: ChannelsName,
    /// Whether depths and values are kept as they are, or rounded to grids
    /// within the tolerance and stored as small numbers
    #[arg(long, value_enum, default_value = "exact")]
    codec: values::CodecName,
    /// How the tiles are packed
    #[arg(long, value_enum, default_value = "zstd")]
    block: values::BlockName,
    /// Width and height of a tile, in pixels
    #[arg(long, value_name = "N", default_value = "64")]
    #[arg(value_parser = RangedU64ValueParser::<u32>::new().range(1..=4096))]
    tile: u32,
    /// Bake the mip levels too, each from what was not compressed
    #[arg(long)]
    mip: bool,
    /// Bake these pixels only, half-open, on borders of tiles; `merge` puts
    /// such maps together
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = values::crop)]
    #[arg(conflicts_with = "mip")]
    crop: Option<[u32; 4]>,
    /// Where the samples lie is a function of this and of the pixel
    #[arg(long, value_name = "N", default_value = "0")]
    seed: u64,
    #[command(flatten)]
    effort: Effort,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
    /// Show no progress, and print nothing but what --json asks for
    #[arg(long)]
    quiet: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum KindName {
    /// Deep shadow maps
    Deep,
    /// Maps of layers: pieces of planes with coverage masks, or the first hits of
    /// every pixel
    Layers,
    /// Multilayer transparent shadow maps: runs of compressed layers with counts
    Mtsm,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum ShapeName {
    Box,
    Tent,
    Gaussian,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum ChannelsName {
    Auto,
    Mono,
    Rgb,
}

/// What `bake` was asked.
#[derive(Debug)]
pub(crate) struct Bake {
    pub(crate) scene: PathBuf,
    pub(crate) output: PathBuf,
    pub(crate) settings: BakeSettings,
    /// None: a deep map.
    pub(crate) layers: Option<LayersRequest>,
    /// Whether the map has colours; none: if the scene has.
    pub(crate) coloured: Option<bool>,
    pub(crate) options: BakeOptions,
    pub(crate) seed: u64,
    pub(crate) effort: Effort,
    pub(crate) json: bool,
    pub(crate) quiet: bool,
}

/// What kind of layered map, and of how many layers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LayersRequest {
    pub(crate) kind: LayeredKind,
    pub(crate) max_layers: u32,
    pub(crate) resets: u32,
    /// Places along a side of a pixel, of fragments.
    pub(crate) coverage: u32,
}

impl LayersRequest {
    /// Samples that each of the settings' samples stands for.
    pub(crate) const fn samples(&self) -> u32 {
        match self.kind {
            LayeredKind::Fragments => self.coverage * self.coverage,
            _ => 1,
        }
    }
}

/// 1, 2, 4 or 8.
fn coverage(text: &str) -> Result<u32, String> {
    match text.parse() {
        Ok(side @ (1 | 2 | 4 | 8)) => Ok(side),
        _ => Err("must be 1, 2, 4 or 8".to_owned()),
    }
}

impl BakeFlags {
    /// What a layered map is asked for; none for a deep one.
    fn layers(&self) -> Result<Option<LayersRequest>, String> {
        let refuse = |switch, kinds| Err(format!("{switch} is for maps of kind {kinds}"));
        let kind = match self.kind {
            KindName::Deep if self.layers.is_some() => return refuse("--layers", "layers or mtsm"),
            KindName::Deep if self.resets.is_some() => return refuse("--resets", "mtsm"),
            KindName::Deep | KindName::Mtsm if self.coverage.is_some() => {
                return refuse("--coverage", "layers");
            }
            KindName::Deep => return Ok(None),
            _ if self.mip => return refuse("--mip", "deep"),
            _ if self.crop.is_some() => return refuse("--crop", "deep"),
            _ if self.codec == values::CodecName::Quantized => {
                return refuse("--codec quantized", "deep");
            }
            KindName::Layers if self.resets.is_some() => return refuse("--resets", "mtsm"),
            KindName::Layers if self.tolerance.0.is_some() => {
                return refuse("--tolerance", "deep or mtsm");
            }
            KindName::Layers if self.samples.is_some_and(|samples| samples != 1) => {
                return Err("a map of kind layers has one sample a pixel".to_owned());
            }
            KindName::Layers if self.coverage == Some(1) => LayeredKind::Layers,
            KindName::Layers => LayeredKind::Fragments,
            KindName::Mtsm => LayeredKind::Mtsm,
        };
        let max_layers = self.layers.unwrap_or(MultilayerSettings::MAX_LAYERS);
        let resets = self.resets.unwrap_or(MultilayerSettings::RESETS);
        let coverage = self.coverage.unwrap_or(8);
        Ok(Some(LayersRequest { kind, max_layers, resets, coverage }))
    }
}

/// Refuses a crop that is no part of the map, or cuts tiles.
fn check_crop(crop: [u32; 4], size: [u32; 2], tile: u32) -> Result<(), String> {
    let [left, top, right, bottom] = crop;
    let [width, height] = size;
    if left >= right || top >= bottom || right > width || bottom > height {
        return Err(format!(
            "--crop: X0 < X1 and Y0 < Y1 have to lie in the map of {width} × {height} pixels"
        ));
    }
    let is_border = |edge: u32, end: u32| edge.is_multiple_of(tile) || edge == end;
    let edges = [(left, width), (right, width), (top, height), (bottom, height)];
    if edges.into_iter().all(|(edge, end)| is_border(edge, end)) {
        return Ok(());
    }
    Err(format!(
        "--crop: its edges have to be multiples of {tile}, the width of a --tile, or edges of the \
         map of {width} × {height} pixels"
    ))
}

impl TryFrom<BakeFlags> for Bake {
    type Error = String;

    fn try_from(flags: BakeFlags) -> Result<Self, String> {
        let layers = flags.layers()?;
        if let Some(crop) = flags.crop {
            check_crop(crop, flags.resolution, flags.tile)?;
        }
        let shape = match flags.filter {
            ShapeName::Box => FilterShape::Box,
            ShapeName::Tent => FilterShape::Tent,
            ShapeName::Gaussian => FilterShape::Gaussian,
        };
        let text = |error: dsm_core::Error| error.to_string();
        let width = flags.filter_width.unwrap_or(shape.minimum_width());
        let mut settings = BakeSettings::new(flags.resolution).map_err(text)?;
        settings.tile_size = flags.tile;
        settings.crop = flags.crop;
        settings.sampling = match (layers, flags.samples) {
            (Some(_), None | Some(1)) => PixelSampling::centre(),
            (_, samples) => PixelSampling::new(samples.unwrap_or(16), flags.seed).map_err(text)?,
        };
        settings.filter = Filter::new(shape, width).map_err(text)?;
        settings.tolerance = flags.tolerance.0;
        if let (Some(layers), None) = (layers, settings.tolerance) {
            // Surfaces are kept as they are.
            let is_mtsm = layers.kind == LayeredKind::Mtsm;
            let epsilon = if is_mtsm { MultilayerSettings::TOLERANCE } else { 0.0 };
            settings.tolerance = Some(Tolerance::new(epsilon).map_err(text)?);
        }
        let coloured = match flags.channels {
            ChannelsName::Auto => None,
            ChannelsName::Mono => Some(false),
            ChannelsName::Rgb => Some(true),
        };
        if flags.codec == values::CodecName::Quantized {
            settings.quantization = Some(Quantization::default());
        }
        let pyramid = flags.mip.then(PyramidOptions::default);
        let options = BakeOptions::default()
            .with_codec(flags.codec.into())
            .with_block(flags.block.into())
            .with_pyramid(pyramid);
        let BakeFlags { scene, output, seed, effort, json, quiet, .. } = flags;
        Ok(Self { scene, output, settings, layers, coloured, options, seed, effort, json, quiet })
    }
}
