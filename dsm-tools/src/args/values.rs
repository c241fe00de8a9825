//! Values of switches.

use std::path::{Path, PathBuf};

use clap::builder::{PathBufValueParser, RangedU64ValueParser, TypedValueParser};
use clap::{Args, ValueEnum};
use deepshadow::files::{Codec, Packing};
use deepshadow::scene::detail::{GridChoice, SceneOptions};
use deepshadow::visibility::Tolerance;

use crate::input::STREAM;
use crate::memory;

/// Use of the machine.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct Effort {
    /// Threads to work with [default: all cores]
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(1..=1024))]
    pub(crate) threads: Option<usize>,
}

/// What becomes of warnings.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct Strictness {
    /// Fail after a warning: what there is to write is written, and the exit code is 1
    #[arg(long)]
    pub(crate) strict: bool,
}

/// The name of a volume's grid, and its number among those of that name.
pub(super) fn grid(text: &str) -> Result<GridChoice, String> {
    text.parse().map_err(|error: deepshadow::scene::Error| error.to_string())
}

/// How a scene is read.
#[derive(Clone, Copy, Debug, Args)]
pub(super) struct SceneFlags {
    /// The most memory that the scene may take, with what is built to trace it: bytes, or
    /// with K, M or G [default: three quarters of the machine's]
    #[arg(long, value_name = "BYTES", value_parser = bytes)]
    memory: Option<u64>,
}

impl SceneFlags {
    /// The options of reading it.
    pub(super) fn options(self, grid: Option<GridChoice>, frame: Option<u32>) -> SceneOptions {
        let options = SceneOptions::default();
        let options = options.memory(self.memory.unwrap_or_else(memory::for_a_scene));
        let options = match grid {
            Some(grid) => options.grid(grid),
            None => options,
        };
        match frame {
            Some(frame) => options.frame(frame),
            None => options,
        }
    }
}

/// Packings of tiles.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum BlockName {
    None,
    Zstd,
}

impl From<BlockName> for Packing {
    fn from(name: BlockName) -> Self {
        match name {
            BlockName::None => Self::Plain,
            BlockName::Zstd => Self::Zstd,
        }
    }
}

/// Encodings of tiles.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub(super) enum CodecName {
    Exact,
    Quantized,
}

impl From<CodecName> for Codec {
    fn from(name: CodecName) -> Self {
        match name {
            CodecName::Exact => Self::Exact,
            CodecName::Quantized => Self::Quantized,
        }
    }
}

/// A tolerance, or none for one that fits the samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AutoTolerance(pub(super) Option<Tolerance>);

/// The kinds of image that a command can write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ImageFormat {
    Svg,
    Png,
    Exr,
}

impl ImageFormat {
    const ALL: [(Self, &str); 3] = [(Self::Svg, "svg"), (Self::Png, "png"), (Self::Exr, "exr")];

    fn of(path: &Path) -> Option<Self> {
        let extension = extension(path)?;
        Self::ALL.into_iter().find(|(_, name)| *name == extension).map(|(format, _)| format)
    }

    fn name(self) -> &'static str {
        Self::ALL.into_iter().find(|&(format, _)| format == self).map_or("", |(_, name)| name)
    }
}

fn extension(path: &Path) -> Option<String> {
    Some(path.extension()?.to_str()?.to_ascii_lowercase())
}

/// An image to write. The name's end says which kind it is.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ImageFile {
    pub(crate) path: PathBuf,
    pub(crate) format: ImageFormat,
}

/// Accepts names of images of one of these two kinds.
pub(super) fn image_file(kinds: [ImageFormat; 2]) -> impl TypedValueParser<Value = ImageFile> {
    PathBufValueParser::new().try_map(move |path| {
        match ImageFormat::of(&path).filter(|format| kinds.contains(format)) {
            Some(format) => Ok(ImageFile { path, format }),
            None => {
                let [one, other] = kinds.map(ImageFormat::name);
                Err(format!("the name must end in .{one} or .{other}"))
            }
        }
    })
}

/// Accepts names of maps, and of images that hold the same.
pub(super) fn map_file() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| match extension(&path).as_deref() {
        Some("dsm" | "exr") => Ok(path),
        _ => Err("the name must end in .dsm or .exr"),
    })
}

/// Accepts names of maps.
pub(super) fn dsm_file() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| match extension(&path).as_deref() {
        Some("dsm") => Ok(path),
        _ => Err("the name must end in .dsm"),
    })
}

/// Accepts names of OpenEXR images.
pub(super) fn exr_file() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| match is_exr(&path) {
        true => Ok(path),
        false => Err("the name must end in .exr"),
    })
}

/// Accepts names of pages, and `-` for standard output.
pub(super) fn html_file() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| match extension(&path).as_deref() {
        Some("html" | "htm") => Ok(path),
        _ if path.as_os_str() == STREAM => Ok(path),
        _ => Err("the name must end in .html, or be - for standard output"),
    })
}

/// True if the name is that of an OpenEXR.
pub(crate) fn is_exr(path: &Path) -> bool {
    extension(path).as_deref() == Some("exr")
}

/// True if the name is that of a map or of an OpenEXR.
pub(super) fn is_map_or_exr(path: &Path) -> bool {
    matches!(extension(path).as_deref(), Some("dsm" | "exr"))
}

/// A number that is not NaN or infinite.
pub(super) fn finite(text: &str) -> Result<f32, String> {
    number(text).and_then(|number| {
        if number.is_finite() { Ok(number) } else { Err("it must be finite".to_owned()) }
    })
}

/// A length in scene units.
pub(super) fn length(text: &str) -> Result<f32, String> {
    finite(text).and_then(|length| {
        if length >= 0.0 { Ok(length) } else { Err("it must not be negative".to_owned()) }
    })
}

/// A length in scene units that is not 0.
pub(super) fn positive_length(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(length) if length > 0.0 && length.is_finite() => Ok(length),
        Ok(_) => Err("it must be above 0, and finite".to_owned()),
        Err(_) => Err(format!("\"{text}\" is not a number")),
    }
}

/// A depth, which may be infinite: then everything lies in front of it.
pub(super) fn depth(text: &str) -> Result<f32, String> {
    number(text).and_then(|depth| {
        if depth.is_nan() { Err("a depth must be a number".to_owned()) } else { Ok(depth) }
    })
}

/// An error bound.
pub(super) fn tolerance(text: &str) -> Result<Tolerance, String> {
    number(text).and_then(|epsilon| Tolerance::new(epsilon).map_err(|error| error.to_string()))
}

/// A factor of tolerances.
pub(super) fn scale(text: &str) -> Result<f32, String> {
    number(text).and_then(|scale| {
        let is_scale = 0.0 < scale && scale <= 1.0;
        if is_scale { Ok(scale) } else { Err("it must lie in (0, 1]".to_owned()) }
    })
}

/// An error bound, or none for one that fits the samples.
pub(super) fn auto_tolerance(text: &str) -> Result<AutoTolerance, String> {
    if text.trim() == "auto" {
        Ok(AutoTolerance(None))
    } else {
        tolerance(text).map(Some).map(AutoTolerance)
    }
}

/// A width and height in pixels: two numbers, or one for both.
pub(super) fn resolution(text: &str) -> Result<[u32; 2], String> {
    let (width, height) = text.split_once('x').unwrap_or((text, text));
    let size = [natural(width), natural(height)];
    let [Ok(width), Ok(height)] = size else {
        return Err("a size is a width and a height, as 640x360, or one number".to_owned());
    };
    let size = [width, height];
    if size.iter().all(|side| (1..=65_536).contains(side)) {
        Ok(size)
    } else {
        Err("a map has 1 to 65,536 pixels a side".to_owned())
    }
}

/// The width and height of a light in scene units: two numbers, or one for both.
pub(super) fn light_size(text: &str) -> Result<[f32; 2], String> {
    let (width, height) = text.split_once('x').unwrap_or((text, text));
    match [finite(width), finite(height)] {
        [Ok(width), Ok(height)] if width >= 0.0 && height >= 0.0 => Ok([width, height]),
        [Ok(_), Ok(_)] => Err("a light is not smaller than 0".to_owned()),
        _ => Err("a size is a width and a height, as 1.5x0.5, or one number".to_owned()),
    }
}

/// A part of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Crop {
    /// x₀, y₀, x₁, y₁.
    Edges([u32; 4]),
    /// Which one, from 1, of how many.
    Part(u32, u32),
}

/// A part of a map: its edges, or its number and how many there are.
pub(super) fn crop(text: &str) -> Result<Crop, String> {
    if let Some((index, count)) = text.split_once('/') {
        let (index, count) = (natural(index)?, natural(count)?);
        if index == 0 || index > count {
            return Err("parts are numbered from 1: 1/16 is the first of 16".to_owned());
        }
        return Ok(Crop::Part(index, count));
    }
    let edges = text.split(',').map(natural).collect::<Result<Vec<_>, _>>()?;
    let edges: Result<[u32; 4], _> = edges.try_into();
    let reason = "a crop is its four edges, X0,Y0,X1,Y1, or a part I/N";
    edges.map(Crop::Edges).map_err(|_| reason.to_owned())
}

/// A pixel: its column and row.
pub(super) fn pixel(text: &str) -> Result<[u32; 2], String> {
    let (x, y) = text.split_once(',').ok_or("a pixel is its column and row: X,Y")?;
    Ok([natural(x)?, natural(y)?])
}

/// A number of bytes: 1048576, 1024K, 512M or 1G.
pub(super) fn bytes(text: &str) -> Result<u64, String> {
    let units = [("K", 10), ("M", 20), ("G", 30), ("T", 40)];
    let unit = units.iter().find_map(|(name, bits)| Some((text.strip_suffix(name)?, bits)));
    let (number, bits) = unit.unwrap_or((text, &0));
    let number: Option<u64> = number.trim().parse().ok();
    let bytes = number.and_then(|number| number.checked_mul(1 << bits)).filter(|&bytes| bytes > 0);
    bytes.ok_or_else(|| format!("\"{text}\" is no number of bytes, such as 512M or 1G"))
}

fn natural(text: &str) -> Result<u32, String> {
    let refused = || format!("\"{text}\" is not a whole number from 0 to {}", u32::MAX);
    text.trim().parse().map_err(|_| refused())
}

fn number(text: &str) -> Result<f32, String> {
    text.trim().parse().map_err(|_| format!("\"{text}\" is not a number"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_what_their_switches_can_use() {
        assert_eq!(finite("-0.5"), Ok(-0.5));
        assert!(finite("inf").is_err() && finite("nan").is_err() && finite("1_0").is_err());
        assert_eq!(length("0.5"), Ok(0.5));
        assert!(length("-0.5").is_err() && length("nan").is_err());
        assert_eq!(positive_length("1e-9"), Ok(1e-9));
        for text in ["0", "-1", "inf", "nan", "hair"] {
            assert!(positive_length(text).is_err(), "{text}");
        }
        assert_eq!(depth("inf"), Ok(f32::INFINITY));
        assert!(depth("NaN").is_err());
        assert_eq!(tolerance("0.02").map(Tolerance::epsilon), Ok(0.02_f32));
        assert!(tolerance("1").is_err() && tolerance("-1e-9").is_err());
        assert_eq!(scale("0.25"), Ok(0.25));
        assert!(scale("0").is_err() && scale("1.5").is_err() && scale("nan").is_err());
        assert_eq!(auto_tolerance("auto"), Ok(AutoTolerance(None)));
        assert_eq!(auto_tolerance("0"), Ok(AutoTolerance(Some(Tolerance::EXACT))));
        assert!(auto_tolerance("automatic").is_err());
        assert_eq!(resolution("512"), Ok([512, 512]));
        assert_eq!(resolution("640x360"), Ok([640, 360]));
        for text in ["640x", "-1", "0", "1x0", "65537x1"] {
            assert!(resolution(text).is_err(), "{text}");
        }
        for text in ["64*64", "64,64", "64X64", "64 by 64", "1e3", ""] {
            assert!(resolution(text).is_err_and(|reason| reason.contains("640x360")), "{text}");
            assert!(
                text == "1e3" || light_size(text).is_err_and(|reason| reason.contains("1.5x0.5"))
            );
        }
        assert_eq!(light_size("1.5x0.25"), Ok([1.5, 0.25]));
        assert_eq!(light_size("0"), Ok([0.0; 2]));
        assert!(light_size("1x-1").is_err() && light_size("x").is_err());
        assert_eq!(crop("0,64,128,192"), Ok(Crop::Edges([0, 64, 128, 192])));
        assert_eq!(crop("3/16"), Ok(Crop::Part(3, 16)));
        assert!(crop("0/4").is_err() && crop("5/4").is_err() && crop("1/0").is_err());
        assert!(crop("0,1,2").is_err() && crop("0,1,2,3,4").is_err());
        assert_eq!(pixel("3, 4"), Ok([3, 4]));
        for text in ["3", "3,", "-1,2", "1,2,3", "4294967296,0"] {
            assert!(pixel(text).is_err(), "{text}");
        }
    }

    #[test]
    fn names_say_the_kind_of_image() {
        assert_eq!(ImageFormat::of(Path::new("a.b.PNG")), Some(ImageFormat::Png));
        assert_eq!(ImageFormat::of(Path::new("png")), None);
        assert_eq!(ImageFormat::of(Path::new("a.tif")), None);
    }
}
