//! The switches of `bake`.

use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, RangedU64ValueParser, TypedValueParser};
use clap::{Args, ValueEnum};
use deepshadow::files::PyramidOptions;
use deepshadow::scene::detail::{GridChoice, SceneOptions, frame_path};
use deepshadow::visibility::{Filter, FilterShape};
use deepshadow::{Channels, Kind};

use super::compression::CompressionFlags;
use super::prefilter::PrefilterFlags;
use super::values::{self, Effort, SceneFlags, Strictness};

const EXAMPLES: &str = "\
Examples:
  dsm-tools bake builtin:hairball -o hair.dsm
  dsm-tools bake scene.toml -o map.dsm --resolution 2048 --samples 64 --mip
  dsm-tools bake scene.toml -o left.dsm --resolution 512 --crop 0,0,256,512
  dsm-tools bake scene.toml -o part.dsm --kind mtsm --resolution 512 --crop 3/16
  dsm-tools bake hair.####.toml -o map.####.dsm --frame 12
  dsm-tools bake model.obj -o layers.dsm --kind layers";

/// Bakes the shadow map of a scene's light
///
/// SCENE is a scene file (.toml), a model (.obj, .ply, .gltf, .glb, .hair,
/// .vdb, .usd, .usda, .usdc, .usdz) that is looked at from a light of its own, or builtin:NAME.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct BakeFlags {
    /// A scene file, a model, or builtin:NAME; or for kind prefiltered a map of kind
    /// fragments, layers or deep (.dsm) or a deep image (.exr)
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// The grid of a SCENE that is a .vdb: its name and, where several have it, a
    /// number from 0 [default: density, else the only one]
    #[arg(long, value_name = "NAME[:N]", value_parser = values::grid)]
    grid: Option<GridChoice>,
    /// The map to write
    #[arg(short, long = "output", value_name = "MAP.dsm", value_parser = values::dsm_file())]
    output: PathBuf,
    /// The kind of map
    #[arg(long, default_value = "deep", value_parser = kind())]
    kind: Kind,
    /// Width and height of the map in pixels; one number: a square [default: 512; of
    /// prefiltered 1024; of fragments 1024, or 512 where that is fine enough for strands]
    #[arg(long, value_name = "W[xH]", value_parser = values::resolution)]
    resolution: Option<[u32; 2]>,
    /// Samples a pixel; of kinds layers and fragments times, all over the shutter [default:
    /// 16; of layered maps 1, the ray through the pixel's centre at mid-shutter]
    #[arg(long, value_name = "N")]
    #[arg(value_parser = RangedU64ValueParser::<u32>::new().range(1..=4096))]
    samples: Option<u32>,
    /// The pixel filter
    #[arg(long, value_enum, default_value = "box")]
    filter: ShapeName,
    /// The full width of the pixel filter, in pixels [default: 1, of a tent 2]
    #[arg(long, value_name = "PIXELS", value_parser = values::finite)]
    filter_width: Option<f32>,
    /// Error bound of the transmittance at any depth, in [0, 1); auto is
    /// 0.25/√N for the N samples under the filter, of kind mtsm 0.02, of kind
    /// fragments, where it is that of media alone, 0.005
    #[arg(long, value_name = "auto|E", default_value = "auto", allow_negative_numbers = true)]
    #[arg(value_parser = values::auto_tolerance)]
    tolerance: values::AutoTolerance,
    /// The maximum number of layers of a pixel, the nearest ones, of kinds fragments, layers,
    /// mtsm and prefiltered [default: of fragments and prefiltered all, else 32]
    #[arg(long, value_name = "K")]
    #[arg(value_parser = RangedU64ValueParser::<u32>::new().range(1..=1 << 20))]
    layers: Option<u32>,
    /// Sample places along a side of a pixel, of kind fragments
    /// [default: 8]
    #[arg(long, value_name = "1|2|4|8", value_parser = coverage)]
    coverage: Option<u32>,
    /// Maximum number of times that a pixel's transmittance starts again at 1
    /// after it has come to 0, of kind mtsm [default: 4]
    #[arg(long, value_name = "R")]
    #[arg(value_parser = RangedU64ValueParser::<u32>::new().range(0..=1 << 20))]
    resets: Option<u32>,
    #[command(flatten)]
    prefilter: PrefilterFlags,
    /// Points of the light that the map is made from, of kind attenuation [default: 64;
    /// of a point light 1]
    #[arg(long, value_name = "N")]
    #[arg(value_parser = RangedU64ValueParser::<u32>::new().range(1..=1 << 16))]
    light_samples: Option<u32>,
    /// Views from points of the light, of kind views: 4 are its corners, 9 and 16 grids that
    /// reach them [default: 4; of a point light 1]
    #[arg(long, value_name = "K")]
    #[arg(value_parser = RangedU64ValueParser::<u32>::new().range(1..=1024))]
    views: Option<u32>,
    /// One channel, or three for colours; auto: three if the scene has colours
    #[arg(long, value_enum, default_value = "auto")]
    channels: ChannelsName,
    /// Encoding of depths and values: exact, or rounded to grids within the
    /// tolerance and stored as small numbers
    #[arg(long, value_enum, default_value = "exact")]
    codec: values::CodecName,
    #[command(flatten)]
    compression: CompressionFlags,
    /// What depths may be moved away from the light by, in scene units, of codec
    /// quantized [default: a 16,384th of the depth, and no more than a quarter
    /// of the thinnest strand's width]
    #[arg(long, value_name = "D", allow_negative_numbers = true)]
    #[arg(value_parser = values::positive_length)]
    depth_error: Option<f64>,
    /// Bytes that a map of kind deep may take: the smallest tolerance from --tolerance on
    /// for which it does is found, of functions that are baked once
    #[arg(long, value_name = "BYTES")]
    #[arg(value_parser = RangedU64ValueParser::<u64>::new().range(1..))]
    target_size: Option<u64>,
    /// Packing of tiles
    #[arg(long, value_enum, default_value = "zstd")]
    block: values::BlockName,
    /// Width and height of a tile, in pixels
    #[arg(long, value_name = "N", default_value = "64")]
    #[arg(value_parser = RangedU64ValueParser::<u32>::new().range(1..=4096))]
    tile: u32,
    /// Bake the mip levels too, each from what was not compressed
    #[arg(long)]
    mip: bool,
    /// Bake these pixels only, half-open, on borders of tiles, or part I of N of whole
    /// tiles, I from 1; `merge` puts such maps together
    #[arg(long, value_name = "X0,Y0,X1,Y1|I/N", value_parser = values::crop)]
    #[arg(conflicts_with = "mip")]
    crop: Option<values::Crop>,
    /// The frame of a sequence: its number stands for each run of # in SCENE, in MAP.dsm
    /// and in the paths of a scene file, with zeros to the run's length
    #[arg(long, value_name = "N")]
    frame: Option<u32>,
    /// Seed of the samples' places, with the pixel; of kind attenuation of the light's points
    #[arg(long, value_name = "N", default_value = "0")]
    seed: u64,
    #[command(flatten)]
    reading: SceneFlags,
    #[command(flatten)]
    effort: Effort,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
    /// Show no progress, and print nothing but what --json asks for
    #[arg(long)]
    quiet: bool,
    #[command(flatten)]
    strictness: Strictness,
}

/// Accepts the names of kinds of map.
fn kind() -> impl TypedValueParser<Value = Kind> {
    let names = Kind::ALL.iter().map(|kind| PossibleValue::new(kind.name()).help(kind.about()));
    PossibleValuesParser::new(names)
        .try_map(|name| Kind::named(&name).ok_or("there is no such kind of map"))
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

/// A checked `bake`.
#[derive(Debug)]
pub(crate) struct Bake {
    pub(crate) scene: PathBuf,
    pub(crate) scene_options: SceneOptions,
    pub(crate) output: PathBuf,
    pub(crate) settings: deepshadow::Bake,
    /// That no resolution was told: it follows the scene.
    pub(crate) finds_resolution: bool,
    pub(crate) effort: Effort,
    pub(crate) json: bool,
    pub(crate) quiet: bool,
    pub(crate) strict: bool,
}

/// 1, 2, 4 or 8.
fn coverage(text: &str) -> Result<u32, String> {
    match text.parse() {
        Ok(side @ (1 | 2 | 4 | 8)) => Ok(side),
        _ => Err("must be 1, 2, 4 or 8".to_owned()),
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

impl Bake {
    /// True if another map is made prefiltered, not a scene baked.
    pub(crate) fn is_of_map(&self) -> bool {
        values::is_map_or_exr(&self.scene)
    }
}

impl TryFrom<BakeFlags> for Bake {
    type Error = String;

    fn try_from(flags: BakeFlags) -> Result<Self, String> {
        if values::is_map_or_exr(&flags.scene) {
            if !flags.kind.is_made_of_maps() {
                let kinds = Kind::ALL.iter().filter(|kind| kind.is_made_of_maps());
                let kinds: Vec<_> = kinds.map(|kind| kind.name()).collect();
                return Err(format!(
                    "a .dsm or .exr is baked to --kind {} alone: `convert` makes other maps of it",
                    kinds.join(" or ")
                ));
            }
            if flags.resolution.is_some() {
                return Err("--resolution: a map has that of the map it is made of".to_owned());
            }
            if !matches!(flags.channels, ChannelsName::Auto) {
                return Err("--channels: a map has those of the map it is made of".to_owned());
            }
        }
        let told = flags.resolution.or(flags.kind.resolution());
        // Until the scene is there, any.
        let resolution = told.unwrap_or([512; 2]);
        if flags.crop.is_some() {
            if told.is_none() {
                let kind = flags.kind.name();
                return Err(format!("--crop of kind {kind} needs a --resolution"));
            }
            if values::is_map_or_exr(&flags.scene) {
                return Err("--crop is for scenes, not for maps of maps".to_owned());
            }
        }
        if flags.frame.is_some() && values::is_map_or_exr(&flags.scene) {
            return Err("--frame is for scenes".to_owned());
        }
        let shape = match flags.filter {
            ShapeName::Box => FilterShape::Box,
            ShapeName::Tent => FilterShape::Tent,
            ShapeName::Gaussian => FilterShape::Gaussian,
        };
        let text = |error: deepshadow::Error| error.to_string();
        let width = flags.filter_width.unwrap_or(shape.minimum_width());
        let mut settings = deepshadow::Bake::new(resolution).map_err(text)?.with_kind(flags.kind);
        settings.tile_size = flags.tile;
        settings.crop = match flags.crop {
            None => None,
            Some(values::Crop::Edges(crop)) => {
                check_crop(crop, resolution, flags.tile)?;
                Some(crop)
            }
            Some(values::Crop::Part(index, count)) => {
                let parts = settings.parts(count).map_err(|error| format!("--crop: {error}"))?;
                parts.get(index as usize - 1).copied()
            }
        };
        settings.samples = flags.samples;
        settings.filter = Filter::new(shape, width).map_err(|error| error.to_string())?;
        settings.tolerance = flags.tolerance.0;
        settings.max_layers = flags.layers;
        settings.resets = flags.resets;
        settings.coverage = flags.coverage;
        settings.filtering = flags.prefilter.settings();
        settings.light_samples = flags.light_samples;
        settings.views = flags.views;
        settings.channels = match flags.channels {
            ChannelsName::Auto => Channels::Auto,
            ChannelsName::Mono => Channels::Mono,
            ChannelsName::Rgb => Channels::Rgb,
        };
        settings.codec = flags.codec.into();
        settings.compression = flags.compression.compression()?;
        settings.depth_error = flags.depth_error;
        settings.target_size = flags.target_size;
        settings.packing = flags.block.into();
        settings.pyramid = flags.mip.then(PyramidOptions::default);
        settings.seed = flags.seed;
        settings.check().map_err(text)?;
        let BakeFlags { scene, grid, frame, output, reading, effort, .. } = flags;
        let BakeFlags { json, quiet, strictness, .. } = flags;
        let Strictness { strict } = strictness;
        let scene_options = reading.options(grid, frame);
        let output = match frame {
            Some(frame) => frame_path(&output, frame),
            None => output,
        };
        let finds_resolution = told.is_none();
        Ok(Self {
            scene,
            scene_options,
            output,
            settings,
            finds_resolution,
            effort,
            json,
            quiet,
            strict,
        })
    }
}
