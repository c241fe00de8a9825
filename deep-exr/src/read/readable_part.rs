//! A part's attributes, checked, and what the decoder needs of them.

use exr::io::PeekRead;
use exr::meta::attribute::{ChannelList, Compression, LevelMode, LineOrder, Text, TileDescription};
use exr::meta::header::Header as FlatHeader;
use exr::meta::{BlockDescription, compute_chunk_count};

use super::choice::ChannelChoice;
use super::header::Header;
use super::part::{FileParts, PartType, RawPart};
use super::plan::{ChannelPlan, describe};
use super::values::required;
use crate::attribute::STRUCTURE;
use crate::codec::packing::Packing;
use crate::error::{Error, Result};
use crate::grid::ChunkGrid;
use crate::layout::Layout;
use crate::limits::Limits;
use crate::selection::Selection;

/// A part that can be read: its header and what the decoder needs.
pub(super) struct ReadablePart {
    pub(super) header: Header,
    pub(super) plan: ChannelPlan,
    /// The header that the `exr` crate's codecs want, for flat parts.
    pub(super) flat: Option<FlatHeader>,
    pub(super) packing: Packing,
    pub(super) grid: ChunkGrid,
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
        selection: &Selection,
        file_length: u64,
        limits: &Limits,
    ) -> Result<Self> {
        let (part, selection) = file.choose(selection, limits)?;
        let (deep, tiled) = match part.part_type {
            PartType::Deep { tiled } => (true, tiled),
            PartType::Flat { tiled } => (false, tiled),
            PartType::Other(_) => {
                return Err(Error::NoDepth {
                    reason: "the part is of an unknown type",
                    parts: file.describe(),
                });
            }
        };
        let compression_byte = part.value::<1>("compression", "compression")?;
        let packing = Packing::new(required(part, "compression", compression_byte)?[0], deep)
            .map_err(|(compression, reason)| Error::UnsupportedCompression {
                part: part.title(),
                compression,
                reason,
            })?;
        // The exr crate decodes flat parts only, and does not know ZSTD.
        let known = if deep { 0 } else { packing.id() };
        let compression = Compression::read(&mut &[known][..])
            .map_err(|error| part.error("compression", error.to_string()))?;

        let data_window = part.window("dataWindow")?;
        let data_window = required(part, "dataWindow", data_window)?;
        let [width, height] = data_window.size();
        let pixels = width * height;
        if pixels > limits.max_pixels {
            return Err(Error::LimitExceeded {
                place: format!("part {}, data window {width} x {height}", part.title()),
                what: "number of pixels",
                value: pixels,
                limit: limits.max_pixels,
            });
        }

        let channels = read_channels(part, limits)?;
        let listed = describe(part, &channels)?;
        let names: Vec<_> = listed.iter().map(|channel| channel.name.as_str()).collect();
        let choice =
            ChannelChoice::find(&names, &selection, !deep).map_err(|refusal| Error::Channels {
                part: part.title(),
                reason: refusal.reason(),
                channels: part.list_channels(),
            })?;
        let read = choice.names(&names);
        let plan = ChannelPlan::new(&listed, &choice);
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
            Layout::ScanLines => ChunkGrid::new(size, [size[0], lines], false, data_window.min),
            Layout::Tiles { width, height } => {
                ChunkGrid::new(size, [width, height], true, data_window.min)
            }
        };
        let (table_offset, chunks_offset) = locate_tables(file, part, chunk_count)?;

        let world_to_camera = part.matrix("worldToCamera");
        let world_to_ndc = part.matrix("worldToNDC");
        let header = Header {
            part_name: part.name(),
            data_window,
            display_window: part.window("displayWindow")?.unwrap_or(data_window),
            width: size[0],
            height: size[1],
            pixel_aspect: part.floats("pixelAspectRatio", "float")?.map_or(1.0, |[value]| value),
            screen_window_center: part.floats("screenWindowCenter", "v2f")?.unwrap_or_default(),
            screen_window_width: part.floats("screenWindowWidth", "float")?.map_or(1.0, |[v]| v),
            deep,
            layout,
            has_levels: matches!(blocks, BlockDescription::Tiles(tiles)
                if tiles.level_mode != LevelMode::Singular),
            compression: packing.name(),
            alpha: plan.alpha_channels(),
            has_z_back: plan.has_z_back(),
            channels: listed,
            read,
            found_chunks: 0,
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
            FlatHeader::new(Text::default(), (width as usize, height as usize), channels.list)
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

fn read_channels(part: &RawPart, limits: &Limits) -> Result<ChannelList> {
    let found = part.attribute("channels");
    let (attribute, _) = required(part, "channels", found)?;
    if attribute.type_name != b"chlist" {
        return Err(part.error("channels", "is not of type 'chlist'"));
    }
    // A channel takes at least a one-byte name, its end and 16 bytes.
    let most = u64::from(limits.max_channels);
    let count = attribute.value.len() as u64 / 18;
    if count > most.saturating_mul(LARGEST_CHANNEL / 18) {
        return Err(Error::LimitExceeded {
            place: format!("part {}", part.title()),
            what: "length of the channel list in bytes",
            value: attribute.value.len() as u64,
            limit: most.saturating_mul(LARGEST_CHANNEL),
        });
    }
    let channels = ChannelList::read(&mut PeekRead::new(attribute.value.as_slice()))
        .map_err(|error| part.error("channels", error.to_string()))?;
    if channels.list.len() as u64 > most {
        return Err(Error::LimitExceeded {
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

fn read_blocks(part: &RawPart, tiled: bool) -> Result<(BlockDescription, Layout)> {
    if !tiled {
        return Ok((BlockDescription::ScanLines, Layout::ScanLines));
    }
    let bytes = part.value::<9>("tiles", "tiledesc")?;
    let bytes = required(part, "tiles", bytes)?;
    let tiles = TileDescription::read(&mut &bytes[..])
        .and_then(|tiles| tiles.validate().map(|()| tiles))
        .map_err(|error| part.error("tiles", error.to_string()))?;
    let layout = Layout::Tiles {
        width: tiles.tile_size.width() as u32,
        height: tiles.tile_size.height() as u32,
    };
    Ok((BlockDescription::Tiles(tiles), layout))
}

/// Where the part's offset table begins, and where the tables end. The tables
/// follow the headers in the order of the parts, eight bytes a chunk.
fn locate_tables(file: &FileParts, part: &RawPart, chunk_count: u64) -> Result<(u64, u64)> {
    let stated = |part: &RawPart| -> Result<Option<u64>> {
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
