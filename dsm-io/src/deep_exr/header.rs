//! What a part's header says about its pixels.

use dsm_core::PixelWindow;
use exr::io::PeekRead;
use exr::meta::attribute::{ChannelList, Compression, LevelMode, LineOrder, Text, TileDescription};
use exr::meta::header::Header;
use exr::meta::{BlockDescription, compute_chunk_count};

use super::channels::{ChannelPlan, ExrChannel};
use super::codec::Packing;
use super::grid::BlockGrid;
use super::part::{ExrAttribute, FileParts, PartType, RawPart};
use super::{AlphaChannels, DeepExrError};
use crate::Limits;

/// Windows may not reach further (OpenEXR's own bound: sizes then fit i32).
pub(super) const FARTHEST_PIXEL: i32 = i32::MAX / 2;

/// How the pixels of a part are cut into chunks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ExrLayout {
    /// Scan lines over the whole width.
    ScanLines,
    /// Tiles; of a mip- or rip-mapped part only level (0, 0) is read.
    Tiles {
        /// Pixels of a whole tile.
        width: u32,
        /// Pixels of a whole tile.
        height: u32,
        /// Whether smaller levels follow, which are not read.
        has_levels: bool,
    },
}

/// The header of the part that is being read.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct DeepExrHeader {
    /// Name of the part.
    pub part_name: Option<String>,
    /// The pixels that are stored. Row 0 of [`read_rows`] is its top row.
    ///
    /// [`read_rows`]: super::DeepExrReader::read_rows
    pub data_window: PixelWindow,
    /// The pixels of the whole picture.
    pub display_window: PixelWindow,
    /// Width of the data window in pixels, at least 1.
    pub width: u32,
    /// Height of the data window in pixels, at least 1.
    pub height: u32,
    /// Width of a pixel over its height.
    pub pixel_aspect: f32,
    /// Centre of the screen window.
    pub screen_window_center: [f32; 2],
    /// Width of the screen window.
    pub screen_window_width: f32,
    /// Whether the part is deep; in a flat one each pixel is one sample.
    pub deep: bool,
    /// Scan lines or tiles.
    pub layout: ExrLayout,
    /// Name of the compression, such as `ZIPS`.
    pub compression: &'static str,
    /// Where opacity comes from.
    pub alpha: AlphaChannels,
    /// Whether samples have a back depth.
    pub has_z_back: bool,
    /// All channels, in the file's order, with those that are not read.
    pub channels: Vec<ExrChannel>,
    /// The number of samples of the fullest pixel as the header states it;
    /// `None` where it does not, or states −1 (unknown). Not relied upon.
    pub stated_max_samples: Option<u32>,
    /// `worldToCamera`, for row vectors, as in the file.
    pub world_to_camera: Option<[f32; 16]>,
    /// `worldToNDC`, for row vectors, as in the file.
    pub world_to_ndc: Option<[f32; 16]>,
    /// Every other attribute, in the file's order and byte for byte.
    pub attributes: Vec<ExrAttribute>,
}

/// A part that can be read: its header and what the decoder needs.
pub(super) struct ReadablePart {
    pub(super) header: DeepExrHeader,
    pub(super) plan: ChannelPlan,
    /// The header that the `exr` crate's codecs want, for flat parts.
    pub(super) flat: Option<Header>,
    pub(super) packing: Packing,
    pub(super) grid: BlockGrid,
    /// Index of the part where chunks name theirs.
    pub(super) chunk_part: Option<i32>,
    /// Where this part's offset table begins.
    pub(super) table_offset: u64,
    /// Where the chunks of the file begin, at the earliest.
    pub(super) chunks_offset: u64,
}

impl ReadablePart {
    pub(super) fn new(
        file: &FileParts,
        name: Option<&str>,
        file_length: u64,
        limits: &Limits,
    ) -> Result<Self, DeepExrError> {
        let part = file.choose(name)?;
        let (deep, tiled) = match part.part_type {
            PartType::Deep { tiled } => (true, tiled),
            PartType::Flat { tiled } => (false, tiled),
            PartType::Other(_) => {
                return Err(DeepExrError::NoDepth {
                    reason: "the part is of an unknown type",
                    parts: file.describe(),
                });
            }
        };
        let compression_byte = part.value::<1>("compression", "compression")?;
        let packing =
            Packing::new(part, required(part, "compression", compression_byte)?[0], deep)?;
        let compression = Compression::read(&mut &[packing.id()][..])
            .map_err(|error| part.error("compression", error.to_string()))?;

        let data_window = read_window(part, "dataWindow")?;
        let data_window = required(part, "dataWindow", data_window)?;
        let [width, height] = data_window.size();
        let pixels = width * height;
        if pixels > limits.max_pixels {
            return Err(DeepExrError::LimitExceeded {
                place: format!("part {}, data window {width} x {height}", part.title()),
                what: "number of pixels",
                value: pixels,
                limit: limits.max_pixels,
            });
        }

        let channels = read_channels(part, limits)?;
        let listed = super::channels::describe(part, &channels)?;
        let plan = ChannelPlan::new(&listed).ok_or_else(|| DeepExrError::NoDepth {
            reason: "the part has no channel Z",
            parts: file.describe(),
        })?;
        // A deep pixel has at least its entry in the table of sample counts.
        let pixel_bytes = if deep { 4 } else { plan.bytes_per_sample() };
        let most =
            u128::from(file_length) * u128::from(packing.expansion()) / u128::from(pixel_bytes);
        if u128::from(pixels) > most {
            return Err(part.error(
                "dataWindow",
                format!(
                    "{pixels} pixels, but a file of {file_length} bytes can hold {most} at most"
                ),
            ));
        }

        let size = [width as u32, height as u32];
        let (blocks, layout) = read_blocks(part, tiled)?;
        let lines = if deep { 1 } else { compression.scan_lines_per_block() as u32 };
        let chunk_count = compute_chunk_count(
            if deep { Compression::Uncompressed } else { compression },
            (width as usize, height as usize).into(),
            blocks,
        ) as u64;
        let grid = match layout {
            ExrLayout::ScanLines => BlockGrid::new(size, [size[0], lines], false, data_window.min),
            ExrLayout::Tiles { width, height, .. } => {
                BlockGrid::new(size, [width, height], true, data_window.min)
            }
        };
        let (table_offset, chunks_offset) = locate_tables(file, part, chunk_count)?;

        let world_to_camera = part.matrix("worldToCamera");
        let world_to_ndc = part.matrix("worldToNDC");
        let header = DeepExrHeader {
            part_name: part.name(),
            data_window,
            display_window: read_window(part, "displayWindow")?.unwrap_or(data_window),
            width: size[0],
            height: size[1],
            pixel_aspect: part.floats("pixelAspectRatio", "float")?.map_or(1.0, |[value]| value),
            screen_window_center: part.floats("screenWindowCenter", "v2f")?.unwrap_or_default(),
            screen_window_width: part.floats("screenWindowWidth", "float")?.map_or(1.0, |[v]| v),
            deep,
            layout,
            compression: packing.name(),
            alpha: plan.alpha_channels(),
            has_z_back: plan.has_z_back(),
            channels: listed,
            stated_max_samples: part
                .value("maxSamplesPerPixel", "int")?
                .and_then(|bytes| u32::try_from(i32::from_le_bytes(bytes)).ok()),
            attributes: part
                .attributes
                .iter()
                .map(|(attribute, _)| attribute)
                .filter(|attribute| match attribute.name.as_slice() {
                    b"worldToCamera" => world_to_camera.is_none(),
                    b"worldToNDC" => world_to_ndc.is_none(),
                    name => !STRUCTURE.iter().any(|known| known.as_bytes() == name),
                })
                .cloned()
                .collect(),
            world_to_camera,
            world_to_ndc,
        };
        let flat = (!deep).then(|| {
            Header::new(Text::default(), (width as usize, height as usize), channels.list)
                .with_encoding(compression, blocks, LineOrder::Unspecified)
        });
        Ok(Self {
            header,
            plan,
            flat,
            packing,
            grid,
            chunk_part: file.multi_part.then_some(part.index as i32),
            table_offset,
            chunks_offset,
        })
    }
}

/// Attributes that describe how the file is built, and those with a field of
/// their own.
pub(super) const STRUCTURE: [&str; 14] = [
    "channels",
    "chunkCount",
    "compression",
    "dataWindow",
    "displayWindow",
    "lineOrder",
    "maxSamplesPerPixel",
    "name",
    "pixelAspectRatio",
    "screenWindowCenter",
    "screenWindowWidth",
    "tiles",
    "type",
    "version",
];

impl RawPart {
    /// The value of an attribute of this type and of `N` bytes.
    fn value<const N: usize>(
        &self,
        name: &str,
        type_name: &str,
    ) -> Result<Option<[u8; N]>, DeepExrError> {
        let Some((attribute, _)) = self.attribute(name) else { return Ok(None) };
        if attribute.type_name != type_name.as_bytes() {
            let found = String::from_utf8_lossy(&attribute.type_name);
            return Err(self.error(name, format!("is of type '{found}', not '{type_name}'")));
        }
        let length = attribute.value.len();
        let value = <[u8; N]>::try_from(attribute.value.as_slice());
        value.map(Some).map_err(|_| self.error(name, format!("has {length} bytes, not {N}")))
    }

    fn floats<const N: usize>(
        &self,
        name: &str,
        type_name: &str,
    ) -> Result<Option<[f32; N]>, DeepExrError> {
        let Some((attribute, _)) = self.attribute(name) else { return Ok(None) };
        let (words, rest) = attribute.value.as_chunks::<4>();
        let floats = <[[u8; 4]; N]>::try_from(words).ok();
        match floats {
            Some(floats) if rest.is_empty() && attribute.type_name == type_name.as_bytes() => {
                Ok(Some(floats.map(f32::from_le_bytes)))
            }
            _ => Err(self.error(name, format!("is not a '{type_name}' of {} bytes", 4 * N))),
        }
    }

    /// A matrix; one of another type is left to the free attributes.
    fn matrix(&self, name: &str) -> Option<[f32; 16]> {
        self.floats(name, "m44f").ok().flatten()
    }
}

fn required<T>(part: &RawPart, name: &str, value: Option<T>) -> Result<T, DeepExrError> {
    value.ok_or_else(|| part.error(name, "is missing"))
}

fn read_window(part: &RawPart, name: &str) -> Result<Option<PixelWindow>, DeepExrError> {
    let Some(bytes) = part.value::<16>(name, "box2i")? else { return Ok(None) };
    let (words, _) = bytes.as_chunks::<4>();
    let [x0, y0, x1, y1] = [0, 1, 2, 3].map(|i| i32::from_le_bytes(words[i]));
    let window = PixelWindow { min: [x0, y0], max: [x1, y1] };
    let reason = if x1 < x0 || y1 < y0 {
        "has no pixels"
    } else if [x0, y0].iter().any(|&v| v <= -FARTHEST_PIXEL)
        || [x1, y1].iter().any(|&v| v >= FARTHEST_PIXEL)
    {
        "reaches further than 2^30 pixels"
    } else {
        return Ok(Some(window));
    };
    Err(part.error(name, format!("({x0}, {y0}) to ({x1}, {y1}) {reason}")))
}

fn read_channels(part: &RawPart, limits: &Limits) -> Result<ChannelList, DeepExrError> {
    let found = part.attribute("channels");
    let (attribute, _) = required(part, "channels", found)?;
    if attribute.type_name != b"chlist" {
        return Err(part.error("channels", "is not of type 'chlist'"));
    }
    // A channel takes at least a one-byte name, its end and 16 bytes.
    let most = u64::from(limits.max_channels);
    let count = attribute.value.len() as u64 / 18;
    if count > most.saturating_mul(LARGEST_CHANNEL / 18) {
        return Err(DeepExrError::LimitExceeded {
            place: format!("part {}", part.title()),
            what: "length of the channel list in bytes",
            value: attribute.value.len() as u64,
            limit: most.saturating_mul(LARGEST_CHANNEL),
        });
    }
    let channels = ChannelList::read(&mut PeekRead::new(attribute.value.as_slice()))
        .map_err(|error| part.error("channels", error.to_string()))?;
    if channels.list.len() as u64 > most {
        return Err(DeepExrError::LimitExceeded {
            place: format!("part {}", part.title()),
            what: "number of channels",
            value: channels.list.len() as u64,
            limit: most,
        });
    }
    Ok(channels)
}

/// Name of 255 bytes, its end, 16 bytes.
const LARGEST_CHANNEL: u64 = 272;

fn read_blocks(part: &RawPart, tiled: bool) -> Result<(BlockDescription, ExrLayout), DeepExrError> {
    if !tiled {
        return Ok((BlockDescription::ScanLines, ExrLayout::ScanLines));
    }
    let bytes = part.value::<9>("tiles", "tiledesc")?;
    let bytes = required(part, "tiles", bytes)?;
    let tiles = TileDescription::read(&mut &bytes[..])
        .and_then(|tiles| tiles.validate().map(|()| tiles))
        .map_err(|error| part.error("tiles", error.to_string()))?;
    let layout = ExrLayout::Tiles {
        width: tiles.tile_size.width() as u32,
        height: tiles.tile_size.height() as u32,
        has_levels: tiles.level_mode != LevelMode::Singular,
    };
    Ok((BlockDescription::Tiles(tiles), layout))
}

/// Where the part's offset table begins, and where the tables end. The tables
/// follow the headers in the order of the parts, eight bytes a chunk.
fn locate_tables(
    file: &FileParts,
    part: &RawPart,
    chunk_count: u64,
) -> Result<(u64, u64), DeepExrError> {
    let stated = |part: &RawPart| -> Result<Option<u64>, DeepExrError> {
        let count = part.value("chunkCount", "int")?.map(i32::from_le_bytes);
        let negative = |count| part.error("chunkCount", format!("is {count}"));
        count.map(|count| u64::try_from(count).map_err(|_| negative(count))).transpose()
    };
    if let Some(count) = stated(part)?.filter(|&count| count != chunk_count) {
        let reason = format!("is {count}, but the data window has {chunk_count} chunks");
        return Err(part.error("chunkCount", reason));
    }
    let mut table_offset = file.tables_offset;
    for earlier in &file.parts[..part.index] {
        table_offset += 8 * required(earlier, "chunkCount", stated(earlier)?)?;
    }
    let mut chunks_offset = table_offset + 8 * chunk_count;
    for later in &file.parts[part.index + 1..] {
        chunks_offset += 8 * stated(later).ok().flatten().unwrap_or(0);
    }
    Ok((table_offset, chunks_offset))
}
