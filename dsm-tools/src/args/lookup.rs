//! The switches of `lookup`.

use std::path::PathBuf;

use clap::builder::RangedU64ValueParser;
use clap::{Args, ValueEnum};
use deepshadow::visibility::{Bias, Footprint, LevelChoice};
use deepshadow::{
    AttenuationMethod, CoherenceMethod, FilterMethod, HybridMethod, Method, PcfMethod,
    PrefilterMethod, TraceMethod,
};

use super::far_table::FarTableName;
use super::filtering::{self, FilterName};
use super::layer_rule::LayerFlags;
use super::prefilter::AccumulateName;
use super::values::{self, Effort, Strictness};

const EXAMPLES: &str = "\
Examples:
  dsm-tools lookup map.dsm --points points.csv --filter tent --width 4
  dsm-tools lookup map.dsm --points pixels.csv --space raster --level auto
  dsm-tools lookup layers.dsm --points points.csv --rays 64 --light-size 1x0.5
  dsm-tools lookup map.dsm --positions P.exr -o shadow.exr --filter tent";

/// Looks up the shadow factor of each of many points
///
/// Reads points from a CSV file whose header names columns x, y and z, and
/// prints one line of CSV a point, in order: its transmittance (v), or one for
/// each colour (r,g,b). A point outside the map, behind the
/// camera or with a NaN is lit: 1.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct LookupFlags {
    /// A deep shadow map or a layered one (.dsm)
    map: PathBuf,
    /// The points, as CSV; - for standard input
    #[arg(long, value_name = "P.csv", required_unless_present = "positions")]
    points: Option<PathBuf>,
    /// The points, as a picture: channels P.x, P.y and P.z, or P.R, P.G and P.B, or x, y and z
    /// or R, G and B without P
    #[arg(long, value_name = "P.exr", value_parser = values::exr_file())]
    #[arg(conflicts_with = "points", requires = "output")]
    positions: Option<PathBuf>,
    /// The picture of the shadow factors of --positions, in Y or R, G and B
    #[arg(short, long, value_name = "SHADOW.exr", value_parser = values::exr_file())]
    #[arg(requires = "positions")]
    output: Option<PathBuf>,
    /// The space of x, y and z: a position in the scene; or a position in the map
    /// in pixels, and the depth
    #[arg(long, value_enum, default_value_t = Space::World)]
    space: Space,
    /// The method: filtering (of a map of kind mtsm the first
    /// runs, of kind layers all); shadow rays from the point to the light through a layered map;
    /// percentage closer filtering over the light's outline in a layered
    /// map; lookups in the levels of a prefiltered one; short rays through --near and such
    /// lookups beyond; lookups of what a place sees of the light in an attenuation map; or
    /// shadow rays only where that can have changed from point to point, through a map of kind
    /// mtsm, layers or views (coherence) [default:
    /// filter, of layered maps trace, of prefiltered ones prefilter, of attenuation ones
    /// attenuation]
    #[arg(long, value_enum)]
    method: Option<MethodName>,
    /// The map of kind fragments that short rays go through (hybrid)
    #[arg(long, value_name = "MAP.dsm", value_parser = values::dsm_file())]
    near: Option<PathBuf>,
    /// Shadow rays from every point (trace; hybrid: short ones; coherence: at most, a square
    /// number), or taps (pcf) [default: 256; hybrid: 16]
    #[arg(long, value_name = "N")]
    #[arg(value_parser = RangedU64ValueParser::<u32>::new().range(1..=65_536))]
    rays: Option<u32>,
    /// Width and height of the light in scene units, of a disk or a sphere the
    /// diameter; 0: a point (trace, pcf, prefilter) [default: the map's]
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
    /// Seed of the points of the light, with the point's number (trace, pcf)
    #[arg(long, value_name = "N", default_value = "0")]
    seed: u64,
    /// The filter: point reads the pixel that contains the point, the others
    /// average all pixels that they reach around it (filter; attenuation: tent interpolates four)
    #[arg(long, value_enum, default_value_t = FilterName::Point)]
    filter: FilterName,
    /// Full width of the filter in pixels of level 0; the minimum is 1, of a
    /// tent 2 [default: the minimum]
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    width: Option<f32>,
    /// Level of the map's pyramid that is read, 0 being the finest; between
    /// two, both are; auto: the one whose pixels are half as wide as the
    /// filter
    #[arg(long, value_name = "L|auto", default_value = "0", allow_negative_numbers = true)]
    #[arg(value_parser = filtering::level)]
    level: LevelChoice,
    /// Depth bias in scene units (filter, pcf, prefilter), or how far a layer may lie from the
    /// point (attenuation) [default: 0; prefilter: 1.2 pixel sides at the point's depth;
    /// attenuation: 2 of them]; or ray offset, the
    /// distance from the point at which rays begin (trace) [default: a pixel's
    /// side at the point's depth; of fragments an eighth of it]
    #[arg(long, value_name = "B", allow_negative_numbers = true)]
    #[arg(value_parser = values::finite)]
    bias: Option<f32>,
    /// Print {points, rays, open_s, lookup_s} as a line of JSON on stderr, and
    /// the numbers of rays outside the map and of points behind the light
    #[arg(long)]
    stats: bool,
    #[command(flatten)]
    effort: Effort,
    /// Show no progress
    #[arg(long)]
    quiet: bool,
    #[command(flatten)]
    strictness: Strictness,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum MethodName {
    Filter,
    Trace,
    Pcf,
    Prefilter,
    Hybrid,
    Attenuation,
    Coherence,
}

/// The space of the coordinates of points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Space {
    World,
    Raster,
}

/// Where the points come from.
#[derive(Debug)]
pub(crate) enum Points {
    Csv(PathBuf),
    /// A picture of points, and that of their answers.
    Picture {
        positions: PathBuf,
        output: PathBuf,
    },
}

/// A checked `lookup`.
#[derive(Debug)]
pub(crate) struct Lookup {
    pub(crate) map: PathBuf,
    pub(crate) points: Points,
    pub(crate) space: Space,
    /// None: by the map's kind.
    method: Option<MethodName>,
    pub(crate) light_size: Option<[f32; 2]>,
    pub(crate) seed: u64,
    filter: FilterMethod,
    trace: TraceMethod,
    pcf: PcfMethod,
    prefilter: PrefilterMethod,
    hybrid: HybridMethod,
    attenuation: AttenuationMethod,
    /// None: the rays are no square.
    coherence: Option<CoherenceMethod>,
    /// Whether four pixels are interpolated, if the filter is one for that.
    bilinear: Result<bool, String>,
    has_level: bool,
    /// The map that short rays go through.
    pub(crate) near: Option<PathBuf>,
    /// Switches that were given, of rays and of filters.
    has_rays: bool,
    has_light_size: bool,
    has_accumulate: bool,
    has_rules: bool,
    has_far_table: bool,
    has_filter: bool,
    has_start_before_point: bool,
    pub(crate) stats: bool,
    pub(crate) effort: Effort,
    pub(crate) quiet: bool,
    pub(crate) strict: bool,
}

impl TryFrom<LookupFlags> for Lookup {
    type Error = String;

    fn try_from(flags: LookupFlags) -> Result<Self, String> {
        let LookupFlags { map, space, filter, width, level, bias, stats, effort, .. } = flags;
        let points = match (flags.points, flags.positions, flags.output) {
            (_, Some(positions), Some(output)) => Points::Picture { positions, output },
            (Some(points), ..) => Points::Csv(points),
            _ => return Err("--points or --positions tell what is asked for".to_owned()),
        };
        let LookupFlags { method, rays, light_size, layers, far_table, seed, quiet, .. } = flags;
        let accumulate = flags.accumulate;
        let prefilter = PrefilterMethod::new();
        let prefilter = bias.map_or(prefilter, |bias| prefilter.with_bias(bias.into()));
        let prefilter = accumulate.map_or(prefilter, |name| prefilter.with_accumulate(name.into()));
        let footprint = filtering::footprint(filter, width)?;
        let trace = layers.set(with_start(TraceMethod::new(rays.unwrap_or(RAYS)), bias));
        let request = Self {
            map,
            points,
            space,
            method,
            light_size,
            seed,
            filter: FilterMethod { footprint, level, bias: Bias::Depth(bias.unwrap_or(0.0)) },
            trace: far_table.map_or(trace, |table| trace.with_far_table(table.into())),
            pcf: PcfMethod::new(rays.unwrap_or(RAYS)).with_bias(bias.unwrap_or(0.0).into()),
            prefilter,
            attenuation: bias.map_or(AttenuationMethod::new(), |bias| {
                AttenuationMethod::new().with_bias(bias.into())
            }),
            coherence: filtering::coherence(rays.unwrap_or(RAYS), bias.map(f64::from)),
            bilinear: filtering::is_bilinear(filter, width),
            has_level: level != LevelChoice::FINEST,
            hybrid: HybridMethod::new(rays.unwrap_or(SHORT_RAYS)).with_lookup(prefilter),
            near: flags.near,
            has_rays: rays.is_some(),
            has_light_size: light_size.is_some(),
            has_accumulate: accumulate.is_some(),
            has_rules: layers.is_given(),
            has_far_table: far_table.is_some(),
            has_filter: footprint != Footprint::Point || level != LevelChoice::FINEST,
            has_start_before_point: bias.is_some_and(|bias| bias < 0.0),
            stats,
            effort,
            quiet,
            strict: flags.strictness.strict,
        };
        if let Some(method) = method {
            request.with_method(method)?;
        }
        Ok(request)
    }
}

impl Lookup {
    /// The method of the switches, or else `default`.
    ///
    /// # Errors
    ///
    /// A switch that was given for other methods.
    pub(crate) fn method(&self, default: Method) -> Result<Method, String> {
        self.with_method(self.method.unwrap_or(match default {
            Method::Filter(_) => MethodName::Filter,
            Method::Pcf(_) => MethodName::Pcf,
            Method::Prefilter(_) => MethodName::Prefilter,
            Method::Hybrid(_) => MethodName::Hybrid,
            Method::Attenuation(_) => MethodName::Attenuation,
            Method::Coherence(_) => MethodName::Coherence,
            _ => MethodName::Trace,
        }))
    }

    fn with_method(&self, method: MethodName) -> Result<Method, String> {
        if (self.has_rays || self.has_light_size) && method == MethodName::Filter {
            return Err("--rays and --light-size are for --method trace and pcf".to_owned());
        }
        let is_lookup = [MethodName::Prefilter, MethodName::Attenuation].contains(&method);
        if self.has_rays && is_lookup {
            return Err("--rays is for --method trace and pcf: lookups have none".to_owned());
        }
        if self.near.is_some() != (method == MethodName::Hybrid) {
            let reason = "--method hybrid needs --near, a map of kind fragments; others have no \
                          use for it";
            return Err(reason.to_owned());
        }
        if self.has_accumulate && ![MethodName::Prefilter, MethodName::Hybrid].contains(&method) {
            return Err(AccumulateName::NOT_PREFILTERED.to_owned());
        }
        if self.has_rules && method != MethodName::Trace {
            return Err(LayerFlags::NOT_TRACED.to_owned());
        }
        if self.has_far_table && method != MethodName::Trace {
            return Err(FarTableName::NOT_TRACED.to_owned());
        }
        let is_attenuation = method == MethodName::Attenuation;
        if self.has_filter && method != MethodName::Filter && !is_attenuation {
            return Err("--filter and --level are for --method filter".to_owned());
        }
        if self.has_level && is_attenuation {
            return Err("--level is for --method filter".to_owned());
        }
        let is_traced = [MethodName::Trace, MethodName::Coherence].contains(&method);
        if self.has_start_before_point && is_traced {
            return Err("--bias: a ray offset is not negative".to_owned());
        }
        Ok(match method {
            MethodName::Filter => self.filter.into(),
            MethodName::Trace => self.trace.into(),
            MethodName::Pcf => self.pcf.into(),
            MethodName::Prefilter => self.prefilter.into(),
            MethodName::Hybrid => self.hybrid.into(),
            MethodName::Attenuation => {
                self.attenuation.with_bilinear(self.bilinear.clone()?).into()
            }
            MethodName::Coherence => {
                self.coherence.ok_or_else(|| filtering::NO_SQUARE.to_owned())?.into()
            }
        })
    }
}

/// The default number of short rays.
const SHORT_RAYS: u32 = 16;

/// The default number of rays or taps.
const RAYS: u32 = 256;

fn with_start(method: TraceMethod, bias: Option<f32>) -> TraceMethod {
    match bias {
        Some(start) => method.with_start(start.into()),
        None => method,
    }
}
