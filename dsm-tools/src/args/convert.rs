//! The switches of `convert`.

use std::path::PathBuf;

use clap::builder::RangedU64ValueParser;
use clap::{Args, ValueEnum};
use deepshadow::files::deep_exr::{Compression, Layout, SampleType, Selection};
use deepshadow::files::detail::{CameraConventions, NdcRange, ViewAxis};
use deepshadow::files::{Codec, ConvertOptions, ExportOptions, Packing, WriteOptions};
use deepshadow::visibility::Tolerance;
use deepshadow::visibility::detail::Quantization;

use super::compression::CompressionFlags;
use super::selection::SelectionFlags;
use super::values::{self, Effort, Strictness};

const EXAMPLES: &str = "\
Examples:
  dsm-tools convert deep.exr map.dsm --tolerance 0.01
  dsm-tools convert map.dsm small.dsm --tolerance 0.01 --codec quantized
  dsm-tools convert layers.exr map.dsm --layer beauty
  dsm-tools convert map.dsm deep.exr --exr-layout tiled --exr-type half";

/// Makes a map from a deep image, a flat depth image or another map; or a
/// deep image from a map
///
/// Prints what had to be clamped, dropped or assumed.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct ConvertFlags {
    /// A deep .exr, a flat .exr with a channel Z, or a .dsm; its content
    /// tells which; - for standard input
    #[arg(value_name = "IN")]
    input: PathBuf,
    /// The map (.dsm) or, if IN is one, the deep image (.exr) to write
    #[arg(value_name = "OUT", value_parser = values::map_file())]
    output: PathBuf,
    /// Error bound of the transmittance at any depth, in [0, 1); 0 copies
    /// [default: 0; of an .exr 1e-5, at least 1e-6].
    /// Of a .dsm this is added to what it states already
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    #[arg(value_parser = values::tolerance)]
    tolerance: Option<Tolerance>,
    /// Bytes that a .dsm may take: the smallest tolerance from --tolerance on for which it
    /// does is found, and told
    #[arg(long, value_name = "BYTES")]
    #[arg(value_parser = RangedU64ValueParser::<u64>::new().range(1..))]
    target_size: Option<u64>,
    /// Encoding of the depths and values of a .dsm: exact, or rounded to grids within
    /// the tolerance and stored as small numbers [default: exact]
    #[arg(long, value_enum)]
    codec: Option<values::CodecName>,
    #[command(flatten)]
    compression: CompressionFlags,
    /// What depths may be moved away from the light by, in scene units, of codec
    /// quantized [default: a 16,384th of the depth]
    #[arg(long, value_name = "D", allow_negative_numbers = true)]
    #[arg(value_parser = values::positive_length)]
    depth_error: Option<f64>,
    /// Packing of the tiles of a .dsm [default: zstd]
    #[arg(long, value_enum)]
    block: Option<values::BlockName>,
    /// Width and height of tiles, in pixels [default: 64]
    #[arg(long, value_name = "N")]
    #[arg(value_parser = RangedU64ValueParser::<u32>::new().range(1..=4096))]
    tile: Option<u32>,
    #[command(flatten)]
    selection: SelectionFlags,
    /// Viewing direction in the camera space of an .exr [default: what its
    /// matrices show, else +z, as OpenEXR has it]
    #[arg(long, value_enum, allow_hyphen_values = true)]
    camera_axis: Option<AxisName>,
    /// Range of the worldToNDC of an .exr: unit is [0, 1], screen [-1, 1]
    /// [default: what its matrices show]
    #[arg(long, value_enum)]
    ndc: Option<NdcName>,
    /// Layout of the pixels of an .exr [default: scanline]
    #[arg(long, value_enum)]
    exr_layout: Option<LayoutName>,
    /// Type of the opacities of an .exr; half rounds them to 11 bits
    /// [default: float]
    #[arg(long, value_enum)]
    exr_type: Option<TypeName>,
    /// Compression of an .exr; zstd needs OpenEXR 3.5 to be read
    /// [default: zips]
    #[arg(long, value_enum)]
    exr_compression: Option<CompressionName>,
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

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum LayoutName {
    Scanline,
    Tiled,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum TypeName {
    Float,
    Half,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum CompressionName {
    Zips,
    Rle,
    Zstd,
    None,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum AxisName {
    #[value(name = "+z")]
    PlusZ,
    #[value(name = "-z")]
    MinusZ,
}

impl From<AxisName> for ViewAxis {
    fn from(name: AxisName) -> Self {
        match name {
            AxisName::PlusZ => Self::PlusZ,
            AxisName::MinusZ => Self::MinusZ,
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum NdcName {
    Unit,
    Screen,
}

impl From<NdcName> for NdcRange {
    fn from(name: NdcName) -> Self {
        match name {
            NdcName::Unit => Self::Unit,
            NdcName::Screen => Self::Screen,
        }
    }
}

/// A checked `convert`.
#[derive(Debug)]
pub(crate) struct Convert {
    pub(crate) input: PathBuf,
    pub(crate) output: PathBuf,
    pub(crate) target: ConvertTarget,
    pub(crate) selection: Selection,
    pub(crate) effort: Effort,
    pub(crate) json: bool,
    pub(crate) quiet: bool,
    pub(crate) strict: bool,
}

/// The output format, by the output's name.
#[derive(Debug)]
pub(crate) enum ConvertTarget {
    /// A map, of so many bytes at most.
    Map(ConvertOptions, Option<u64>),
    Image(ExportOptions),
}

const DEFAULT_TILE: u32 = 64;

impl ConvertFlags {
    fn map(&self) -> Result<ConvertOptions, String> {
        let refused = [
            ("--exr-layout", self.exr_layout.is_some()),
            ("--exr-type", self.exr_type.is_some()),
            ("--exr-compression", self.exr_compression.is_some()),
        ];
        if let Some((switch, _)) = refused.iter().find(|(_, is_given)| *is_given) {
            return Err(format!("{switch} is for .exr outputs"));
        }
        let block = self.block.map_or(Packing::Zstd, Packing::from);
        let tile = self.tile.unwrap_or(DEFAULT_TILE);
        let codec = self.codec.map_or(Codec::Exact, Codec::from);
        let write = WriteOptions::default().with_tile_size(tile).with_packing(block);
        let mut tolerance = self.tolerance.unwrap_or_default();
        if self.target_size.is_some() && self.tolerance.is_none() && codec == Codec::Quantized {
            let least = Tolerance::new(Quantization::MIN_TOLERANCE);
            tolerance = least.map_err(|error| error.to_string())?;
        }
        let quantization = self.quantization(codec, tolerance)?;
        let cameras = CameraConventions {
            view_axis: self.camera_axis.map(ViewAxis::from),
            ndc_range: self.ndc.map(NdcRange::from),
        };
        let compression = self.compression.compression()?.unwrap_or_default();
        let write = write.with_codec(codec);
        Ok(ConvertOptions { tolerance, write, cameras, quantization, compression })
    }

    /// The grids of codec `quantized`.
    fn quantization(
        &self,
        codec: Codec,
        tolerance: Tolerance,
    ) -> Result<Option<Quantization>, String> {
        if codec != Codec::Quantized {
            return match self.depth_error {
                Some(_) => Err("--depth-error is for --codec quantized".to_owned()),
                None => Ok(None),
            };
        }
        if tolerance.epsilon() < Quantization::MIN_TOLERANCE {
            let least = Quantization::MIN_TOLERANCE;
            return Err(format!("--codec quantized needs a --tolerance of at least {least:e}"));
        }
        let within = self.depth_error.map(Quantization::within).transpose();
        Ok(Some(within.map_err(|error| error.to_string())?.unwrap_or_default()))
    }

    fn image(&self) -> Result<ExportOptions, String> {
        let refused = [
            ("--block", self.block.is_some()),
            ("--codec", self.codec.is_some()),
            ("--depth-error", self.depth_error.is_some()),
            ("--target-size", self.target_size.is_some()),
            (self.compression.given().unwrap_or_default(), self.compression.given().is_some()),
            ("--camera-axis", self.camera_axis.is_some()),
            ("--ndc", self.ndc.is_some()),
        ];
        if let Some((switch, _)) = refused.iter().find(|(_, is_given)| *is_given) {
            return Err(format!("{switch} is for .dsm outputs"));
        }
        let is_tiled = self.exr_layout == Some(LayoutName::Tiled);
        if self.tile.is_some() && !is_tiled {
            return Err("--tile of an .exr needs --exr-layout tiled".to_owned());
        }
        let defaults = ExportOptions::default();
        let error = self.tolerance.unwrap_or(defaults.error);
        if error.epsilon() < ExportOptions::LEAST_ERROR {
            let least = ExportOptions::LEAST_ERROR;
            return Err(format!("--tolerance of an .exr must be at least {least:e}"));
        }
        Ok(ExportOptions {
            layout: if is_tiled {
                let size = self.tile.unwrap_or(DEFAULT_TILE);
                Layout::Tiles { width: size, height: size }
            } else {
                Layout::ScanLines
            },
            sample_type: match self.exr_type {
                Some(TypeName::Half) => SampleType::Half,
                Some(TypeName::Float) | None => SampleType::Float,
            },
            compression: match self.exr_compression {
                Some(CompressionName::Rle) => Compression::Rle,
                Some(CompressionName::Zstd) => Compression::Zstd,
                Some(CompressionName::None) => Compression::None,
                Some(CompressionName::Zips) | None => Compression::Zips,
            },
            error,
            ..defaults
        })
    }
}

impl TryFrom<ConvertFlags> for Convert {
    type Error = String;

    fn try_from(flags: ConvertFlags) -> Result<Self, String> {
        let target = if values::is_exr(&flags.output) {
            ConvertTarget::Image(flags.image()?)
        } else {
            ConvertTarget::Map(flags.map()?, flags.target_size)
        };
        let ConvertFlags { input, output, selection, effort, json, quiet, strictness, .. } = flags;
        let Strictness { strict } = strictness;
        Ok(Self { input, output, target, selection: selection.into(), effort, json, quiet, strict })
    }
}
