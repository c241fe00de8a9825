//! Settings of a bake from keyword arguments.

use deepshadow::files::{Attribute, Codec, Packing, PyramidOptions};
use deepshadow::visibility::{
    Compression, CompressionMethod, Filter, FilterShape, Side, Tolerance,
};
use deepshadow::{Bake, Channels, Epsilon, Kind, PrefilterSettings};
use pyo3::prelude::*;

use crate::attributes;
use crate::error::{Failure, Result};
use crate::options::Options;
use crate::query::{ACCUMULATE, SHAPES};

/// The packings of tiles by name.
pub(crate) const PACKINGS: [(&str, Packing); 2] =
    [("none", Packing::Plain), ("zstd", Packing::Zstd)];

/// The encodings of tiles by name.
pub(crate) const CODECS: [(&str, Codec); 2] =
    [("exact", Codec::Exact), ("quantized", Codec::Quantized)];

/// The size at which a stack of levels begins where none is told.
const STACK_SIZE: u32 = 128;

/// The settings, and whether a resolution was told.
pub(crate) fn take(given: &Options<'_>) -> Result<(Bake, bool)> {
    let kind = match given.take::<String>("kind")? {
        None => Kind::DEEP,
        Some(name) => Kind::named(&name).ok_or_else(|| {
            let names: Vec<_> = Kind::ALL.iter().map(|kind| kind.name()).collect();
            Failure::setting(format!("kind: '{name}' is none of {}", names.join(", ")))
        })?,
    };
    let told = given.object("resolution")?.map(|size| side_or_both(&size)).transpose()?;
    let size = told.or(kind.resolution()).unwrap_or([512; 2]);
    let mut settings = Bake::new(size)?.with_kind(kind);
    let shape = given.word("filter", &SHAPES)?.unwrap_or(FilterShape::Box);
    let width = given.take("filter_width")?.unwrap_or(shape.minimum_width());
    settings.filter = Filter::new(shape, width)?;
    settings.samples = given.take("samples")?;
    settings.tolerance = given.take("tolerance")?.map(Tolerance::new).transpose()?;
    settings.max_layers = given.take("layers")?;
    settings.coverage = given.take("coverage")?;
    settings.resets = given.take("resets")?;
    settings.light_samples = given.take("light_samples")?;
    settings.views = given.take("views")?;
    settings.compression = compression(given)?;
    settings.filtering = filtering(given)?;
    let channels = [("auto", Channels::Auto), ("mono", Channels::Mono), ("rgb", Channels::Rgb)];
    settings.channels = given.word("channels", &channels)?.unwrap_or(settings.channels);
    settings.codec = given.word("codec", &CODECS)?.unwrap_or(settings.codec);
    settings.depth_error = given.take("depth_error")?;
    settings.packing = given.word("block", &PACKINGS)?.unwrap_or(settings.packing);
    settings.tile_size = given.take("tile")?.unwrap_or(settings.tile_size);
    settings.pyramid = given.take("mip")?.unwrap_or(false).then(PyramidOptions::default);
    settings.crop = given.take("crop")?;
    settings.seed = given.take("seed")?.unwrap_or(settings.seed);
    settings.attributes = attributes::from_dict(given.object("attrs")?.as_ref())?;
    settings.check()?;
    Ok((settings, told.is_some()))
}

/// What the program's bakes say of a scene in headers.
pub(crate) fn describe(settings: Bake, name: &str, shutter: [f64; 2]) -> Bake {
    let [open, close] = shutter;
    let seed = settings.seed.to_string();
    let mut settings = settings;
    for (key, value) in [
        ("bakeScene", name.to_owned()),
        ("bakeSeed", seed),
        ("bakeShutter", format!("{open} {close}")),
    ] {
        settings = settings.with_attribute(key, Attribute::string(&value));
    }
    settings
}

/// One number for both sides, or a width and a height.
fn side_or_both(given: &Bound<'_, PyAny>) -> Result<[u32; 2]> {
    match given.extract::<u32>() {
        Ok(side) => Ok([side; 2]),
        Err(_) => Ok(given.extract()?),
    }
}

/// How functions are compressed, of kind `deep`; `None` if nothing was told.
pub(crate) fn compression(given: &Options<'_>) -> Result<Option<Compression>> {
    let methods = [("greedy", CompressionMethod::Greedy), ("min-link", CompressionMethod::MinLink)];
    let method = given.word("method", &methods)?;
    let sides = [("both", Side::Both), ("lighter", Side::Lighter), ("darker", Side::Darker)];
    let side = given.word("side", &sides)?;
    if method.is_none() && side.is_none() {
        return Ok(None);
    }
    let side = side.unwrap_or_default();
    Ok(Some(Compression::new(method.unwrap_or_default()).with_side(side)))
}

/// How levels are made, of kind `prefiltered`; `None` if nothing was told.
fn filtering(given: &Options<'_>) -> Result<Option<PrefilterSettings>> {
    let preset = given.word("preset", &[("nearest", false), ("paper", true)])?;
    let epsilon: Option<f32> = given.take("epsilon")?;
    let accumulate = given.word("accumulate", &ACCUMULATE)?;
    let levels = given.take::<String>("levels")?.map(|text| stack(&text)).transpose()?;
    let max_level: Option<u32> = given.take("max_level")?;
    let is_given = preset.is_some() || epsilon.is_some() || accumulate.is_some();
    let mut settings = match preset {
        Some(true) => PrefilterSettings::paper(),
        _ => PrefilterSettings::default(),
    };
    if let Some(widths) = epsilon {
        settings = settings.with_epsilon(Epsilon::Widths(widths));
    }
    if let Some(accumulate) = accumulate {
        settings = settings.with_accumulate(accumulate);
    }
    if let Some(size) = levels {
        settings = settings.with_stack_size(size);
    }
    let is_given = is_given || levels.is_some() || max_level.is_some();
    Ok(is_given.then(|| settings.with_max_level(max_level)))
}

/// The size at which a stack begins; `None` for MIP levels alone.
fn stack(text: &str) -> Result<Option<u32>> {
    let size = match text.split_once(':') {
        None if text == "mip" => return Ok(None),
        None if text == "y" => Ok(STACK_SIZE),
        Some(("y", size)) => size.parse(),
        _ => return Err(Failure::setting("levels: must be \"mip\", \"y\" or \"y:N\"")),
    };
    match size {
        Ok(size @ 1..=65_536) => Ok(Some(size)),
        _ => Err(Failure::setting("levels: a stack begins at 1 to 65536 pixels")),
    }
}
