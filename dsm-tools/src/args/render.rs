//! The switches of `render`.

use std::path::PathBuf;

use clap::builder::RangedU64ValueParser;
use clap::{Args, ValueEnum};
use deepshadow::scene::detail::{GridChoice, SceneOptions};
use deepshadow::visibility::{Bias, LevelChoice};
use deepshadow::{
    AttenuationMethod, CoherenceMethod, FilterMethod, HybridMethod, Method as MapMethod, PcfMethod,
    PrefilterMethod, TraceMethod,
};

use super::far_table::FarTableName;
use super::filtering::{self, FilterName};
use super::layer_rule::LayerFlags;
use super::prefilter::AccumulateName;
use super::values::{self, Effort, ImageFile, ImageFormat, SceneFlags, Strictness};

const EXAMPLES: &str = "\
Examples:
  dsm-tools render builtin:pipes -o pipes.png
  dsm-tools render scene.toml -o soft.exr --method trace --rays 64 --factor
  dsm-tools render scene.toml -o picture.png --map map.dsm --compare truth.exr";

/// Renders a scene under its light
///
/// SCENE is what `bake` takes. The light's shadows are looked up in its deep
/// shadow map, in a plain shadow map with percentage closer filtering, or traced
/// through the scene itself.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct RenderFlags {
    /// A scene file, a model, or builtin:NAME
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// The grid of a SCENE that is a .vdb: its name and, where several have it, a
    /// number from 0 [default: density, else the only one]
    #[arg(long, value_name = "NAME[:N]", value_parser = values::grid)]
    grid: Option<GridChoice>,
    /// The picture to write: .png (8 bits, sRGB) or .exr (linear)
    #[arg(short, long = "output", value_name = "IMAGE")]
    #[arg(value_parser = values::image_file([ImageFormat::Png, ImageFormat::Exr]))]
    output: ImageFile,
    /// The map of the light (.dsm): a deep one (filter), a layered one (trace,
    /// pcf), a prefiltered one (prefilter, hybrid), an attenuation one (attenuation)
    /// [default: one that is baked first, as large as `bake` makes it: a deep one
    /// of 16 samples and within 0.01; for trace one of kind fragments, or
    /// with a --rule of kind mtsm; for prefilter and hybrid one of kind prefiltered, for
    /// attenuation of kind attenuation]
    #[arg(long, value_name = "MAP.dsm", value_parser = values::dsm_file())]
    map: Option<PathBuf>,
    /// The source of shadows: filtered lookups in the deep map; shadow rays
    /// through a layered map; percentage closer filtering of a
    /// plain shadow map or, with --map, over the light's outline in a layered
    /// one; lookups in the levels of a prefiltered map; short rays through the scene
    /// and such lookups beyond; lookups of what each place sees of the light in an
    /// attenuation map; or rays through the scene, all of them (reference) or where
    /// visibility can have changed from point to point (coherence; with --map through a
    /// map of kind mtsm, layers or views)
    #[arg(long, value_enum, default_value = "filter")]
    method: MethodName,
    /// Shadow rays from every point to the light (trace; reference: 1 for a
    /// point light on a scene where nothing moves; hybrid: short ones; coherence: at most, a
    /// square number), or taps of a lookup (pcf: a square number, unless there is a --map)
    /// [default: 16; coherence: 256]
    #[arg(long, value_name = "N")]
    #[arg(value_parser = RangedU64ValueParser::<u32>::new().range(1..=65_536))]
    rays: Option<u32>,
    /// Camera rays a pixel
    #[arg(long, value_name = "N", default_value = "16")]
    #[arg(value_parser = RangedU64ValueParser::<u32>::new().range(1..=4096))]
    samples: u32,
    /// Width and height of the picture in pixels; one number: a square
    /// [default: the camera's]
    #[arg(long, value_name = "WxH", value_parser = values::resolution)]
    resolution: Option<[u32; 2]>,
    /// Width and height of the light in scene units, of a disk or a sphere the
    /// diameter; 0: a point (reference) [default: the scene's]
    #[arg(long, value_name = "WxH", value_parser = values::light_size)]
    light_size: Option<[f32; 2]>,
    #[command(flatten)]
    layers: LayerFlags,
    /// Sums of optical depth in place of far fragments, for speed; auto: if a
    /// trial on the map's receivers finds no difference that matters (trace, of
    /// kind fragments) [default: auto]
    #[arg(long, value_enum)]
    far_table: Option<FarTableName>,
    /// How opacities of one pixel and of several levels come together (prefilter, hybrid)
    /// [default: as when the map was baked]
    #[arg(long, value_enum)]
    accumulate: Option<AccumulateName>,
    /// The filter over the map's pixels around a point (filter; attenuation: tent
    /// interpolates four, point takes one)
    #[arg(long, value_enum, default_value = "tent")]
    filter: FilterName,
    /// Full width of the filter in pixels of the map's level 0; the minimum is 1,
    /// of a tent 2 (filter; pcf: any above 0) [default: the minimum; pcf: 1]
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    width: Option<f32>,
    /// Level of the map's pyramid that is read, or auto (filter)
    #[arg(long, value_name = "L|auto", default_value = "0", allow_negative_numbers = true)]
    #[arg(value_parser = filtering::level)]
    level: LevelChoice,
    /// Depth bias in scene units; auto: by the slope of each point's surface and
    /// the map's pixels (filter, pcf), or by its tangent plane (prefilter); or ray offset, the distance from the
    /// point at which rays begin; auto: a pixel's side there, of fragments an
    /// eighth of it (trace; pcf with --map: a depth bias)
    #[arg(long, value_name = "auto|B", default_value = "auto", allow_negative_numbers = true)]
    #[arg(value_parser = filtering::bias)]
    bias: Bias,
    /// The shadow factor alone, unshaded
    #[arg(long)]
    factor: bool,
    /// Print the error against this picture of the same size
    #[arg(long, value_name = "REF.exr", value_parser = values::exr_file())]
    compare: Option<PathBuf>,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
    /// Seed of the rays, with the pixel
    #[arg(long, value_name = "N", default_value = "0")]
    seed: u64,
    #[command(flatten)]
    reading: SceneFlags,
    #[command(flatten)]
    effort: Effort,
    /// Show no progress, and print nothing but what --json and --compare ask
    /// for
    #[arg(long)]
    quiet: bool,
    #[command(flatten)]
    strictness: Strictness,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum MethodName {
    Filter,
    Trace,
    Pcf,
    Prefilter,
    Hybrid,
    Attenuation,
    Coherence,
    Reference,
}

/// A source of shadows.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Method {
    /// A map: a file, or one that is baked first.
    Map { map: Option<PathBuf>, method: MapMethod },
    /// Percentage closer filtering of a plain shadow map.
    Plain { taps: u32, width: f32, bias: Bias },
    /// Rays through the scene.
    Reference { rays: u32 },
    /// Rays through the scene where visibility can have changed.
    Coherent(CoherenceMethod),
}

impl Method {
    /// The method's name on the command line.
    pub(crate) const fn name(&self) -> &'static str {
        match self {
            Self::Map { method, .. } => method.name(),
            Self::Plain { .. } => "pcf",
            Self::Reference { .. } => "reference",
            Self::Coherent(_) => "coherence",
        }
    }
}

/// A checked `render`.
#[derive(Debug)]
pub(crate) struct Render {
    pub(crate) scene: PathBuf,
    pub(crate) scene_options: SceneOptions,
    pub(crate) output: ImageFile,
    pub(crate) method: Method,
    pub(crate) samples: u32,
    pub(crate) resolution: Option<[u32; 2]>,
    pub(crate) light_size: Option<[f32; 2]>,
    pub(crate) factor: bool,
    pub(crate) compare: Option<PathBuf>,
    pub(crate) json: bool,
    pub(crate) seed: u64,
    pub(crate) effort: Effort,
    pub(crate) quiet: bool,
    pub(crate) strict: bool,
}

impl TryFrom<RenderFlags> for Render {
    type Error = String;

    fn try_from(flags: RenderFlags) -> Result<Self, String> {
        let RenderFlags { width, level, bias, filter, map, .. } = flags;
        let default = if flags.method == MethodName::Coherence { 256 } else { 16 };
        let rays = flags.rays.unwrap_or(default);
        if flags.layers.is_given() && flags.method != MethodName::Trace {
            return Err(LayerFlags::NOT_TRACED.to_owned());
        }
        if flags.far_table.is_some() && flags.method != MethodName::Trace {
            return Err(FarTableName::NOT_TRACED.to_owned());
        }
        let is_prefiltered = [MethodName::Prefilter, MethodName::Hybrid].contains(&flags.method);
        if flags.accumulate.is_some() && !is_prefiltered {
            return Err(AccumulateName::NOT_PREFILTERED.to_owned());
        }
        let method = match flags.method {
            MethodName::Filter => {
                let footprint = filtering::footprint(filter, width)?;
                Method::Map { map, method: FilterMethod { footprint, level, bias }.into() }
            }
            MethodName::Trace => {
                let method = match depth(bias) {
                    Some(start) if start < 0.0 => {
                        return Err("--bias: a ray offset is not negative".to_owned());
                    }
                    Some(start) => TraceMethod::new(rays).with_start(start),
                    None => TraceMethod::new(rays),
                };
                let method = match flags.far_table {
                    Some(table) => method.with_far_table(table.into()),
                    None => method,
                };
                Method::Map { map, method: flags.layers.set(method).into() }
            }
            MethodName::Pcf if map.is_some() => {
                let method = match depth(bias) {
                    Some(bias) => PcfMethod::new(rays).with_bias(bias),
                    None => PcfMethod::new(rays),
                };
                Method::Map { map, method: method.into() }
            }
            MethodName::Prefilter | MethodName::Hybrid => {
                let lookup = PrefilterMethod::new();
                let lookup = depth(bias).map_or(lookup, |bias| lookup.with_bias(bias));
                let accumulate = flags.accumulate;
                let lookup = accumulate.map_or(lookup, |name| lookup.with_accumulate(name.into()));
                let method = match flags.method {
                    MethodName::Hybrid => HybridMethod::new(rays).with_lookup(lookup).into(),
                    _ => lookup.into(),
                };
                Method::Map { map, method }
            }
            MethodName::Attenuation => {
                let method = AttenuationMethod::new();
                let method = depth(bias).map_or(method, |bias| method.with_bias(bias));
                let bilinear = filtering::is_bilinear(filter, width)?;
                Method::Map { map, method: method.with_bilinear(bilinear).into() }
            }
            MethodName::Coherence => {
                let start = depth(bias);
                if start.is_some_and(|start| start < 0.0) {
                    return Err("--bias: a ray offset is not negative".to_owned());
                }
                let method = filtering::coherence(rays, start).ok_or(filtering::NO_SQUARE)?;
                match map {
                    Some(_) => Method::Map { map, method: method.into() },
                    None => Method::Coherent(method),
                }
            }
            MethodName::Reference if map.is_some() => {
                return Err("--map has no use for --method reference".to_owned());
            }
            MethodName::Pcf => {
                let width = width.unwrap_or(1.0);
                if !(width > 0.0 && width.is_finite()) {
                    return Err("--width: a filter has a finite width above 0".to_owned());
                }
                let side = rays.isqrt();
                if side * side != rays || rays > 4096 {
                    return Err("--rays: pcf takes a square number of taps, 1 to 4096".to_owned());
                }
                Method::Plain { taps: rays, width, bias }
            }
            MethodName::Reference => Method::Reference { rays },
        };
        let RenderFlags {
            scene,
            grid,
            output,
            samples,
            resolution,
            factor,
            compare,
            json,
            seed,
            ..
        } = flags;
        let RenderFlags { reading, effort, quiet, light_size, strictness, .. } = flags;
        Ok(Self {
            scene,
            scene_options: reading.options(grid, None),
            output,
            method,
            samples,
            resolution,
            light_size,
            factor,
            compare,
            json,
            seed,
            effort,
            quiet,
            strict: strictness.strict,
        })
    }
}

/// The depth bias; none for auto.
fn depth(bias: Bias) -> Option<f64> {
    match bias {
        Bias::Depth(depth) => Some(depth.into()),
        _ => None,
    }
}
