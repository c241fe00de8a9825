//! Options of conversions from keyword arguments.

use deepshadow::files::deep_exr::detail::ChannelNames;
use deepshadow::files::deep_exr::{Compression, Layout, SampleType, Selection};
use deepshadow::files::detail::{CameraConventions, NdcRange, ViewAxis};
use deepshadow::files::{Codec, ConvertOptions, ExportOptions, Packing, WriteOptions};
use deepshadow::visibility::Tolerance;
use deepshadow::visibility::detail::Quantization;

use crate::bake_settings::{CODECS, PACKINGS, compression};
use crate::error::{Failure, Result};
use crate::options::Options;

/// Width and height of tiles in pixels unless others are told.
const TILE: u32 = 64;

/// The part, layer and channels of an image.
pub(crate) fn selection(
    part: Option<String>,
    layer: Option<String>,
    channels: Option<&str>,
) -> Result<Selection> {
    let mut selection = Selection::from(part.as_deref());
    selection.layer = layer;
    if let Some(channels) = channels {
        selection.channels = channels.parse::<ChannelNames>()?;
    }
    Ok(selection)
}

/// The same of keyword arguments.
pub(crate) fn take_selection(given: &Options<'_>) -> Result<Selection> {
    let channels: Option<String> = given.take("channels")?;
    selection(given.take("part")?, given.take("layer")?, channels.as_deref())
}

/// The options of maps that are made.
pub(crate) fn take_map(given: &Options<'_>) -> Result<ConvertOptions> {
    let tolerance = given.take("tolerance")?.map(Tolerance::new).transpose()?.unwrap_or_default();
    let codec = given.word("codec", &CODECS)?.unwrap_or(Codec::Exact);
    let depth_error: Option<f64> = given.take("depth_error")?;
    let quantization = match (codec, depth_error) {
        (Codec::Quantized, Some(error)) => Some(Quantization::within(error)?),
        (Codec::Quantized, None) => Some(Quantization::default()),
        (_, Some(_)) => return Err(Failure::setting("depth_error is for codec quantized")),
        (_, None) => None,
    };
    let write = WriteOptions::default()
        .with_codec(codec)
        .with_packing(given.word("block", &PACKINGS)?.unwrap_or(Packing::Zstd))
        .with_tile_size(given.take("tile")?.unwrap_or(TILE));
    let cameras = CameraConventions {
        view_axis: given
            .word("camera_axis", &[("+z", ViewAxis::PlusZ), ("-z", ViewAxis::MinusZ)])?,
        ndc_range: given.word("ndc", &[("unit", NdcRange::Unit), ("screen", NdcRange::Screen)])?,
    };
    let compression = compression(given)?.unwrap_or_default();
    Ok(ConvertOptions { tolerance, write, cameras, quantization, compression })
}

/// The layout, compression and type of opacities of images that are written.
pub(crate) fn take_storage(
    given: &Options<'_>,
    [layout, compression, sample_type]: [&str; 3],
) -> Result<(Layout, Compression, SampleType)> {
    let is_tiled = given.word(layout, &[("scanline", false), ("tiled", true)])?;
    let tile: Option<u32> = given.take("tile")?;
    let layout = match (is_tiled, tile) {
        (Some(true), side) => {
            let side = side.unwrap_or(TILE);
            Layout::Tiles { width: side, height: side }
        }
        (_, Some(_)) => return Err(Failure::setting("tile needs the layout tiled")),
        (_, None) => Layout::ScanLines,
    };
    let compressions = [
        ("zips", Compression::Zips),
        ("rle", Compression::Rle),
        ("zstd", Compression::Zstd),
        ("none", Compression::None),
    ];
    let types = [("float", SampleType::Float), ("half", SampleType::Half)];
    Ok((
        layout,
        given.word(compression, &compressions)?.unwrap_or_default(),
        given.word(sample_type, &types)?.unwrap_or_default(),
    ))
}

/// The options of images that are made of maps.
pub(crate) fn take_image(given: &Options<'_>) -> Result<ExportOptions> {
    let names = ["exr_layout", "exr_compression", "exr_type"];
    let (layout, compression, sample_type) = take_storage(given, names)?;
    let defaults = ExportOptions::default();
    let error = given.take("tolerance")?.map(Tolerance::new).transpose()?;
    let error = error.unwrap_or(defaults.error);
    Ok(ExportOptions { layout, compression, sample_type, error, ..defaults })
}
