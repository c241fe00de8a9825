//! The parts of a file, as raw attributes.
//!
//! The attribute lists are scanned here, not by the `exr` crate: its parsed
//! header refuses values that deep files may hold (an unknown
//! `maxSamplesPerPixel`, compressions it does not know) and forgets the bytes
//! of the attributes it understands.

use std::collections::HashSet;

use exr::meta::Requirements;
use exr::meta::magic_number;

use super::choice::{ChannelChoice, Refusal};
use super::source::ByteSource;
use crate::attribute::{Attribute, LONGEST_NAME};
use crate::error::{Error, Result};
use crate::limits::Limits;
use crate::selection::Selection;

/// What a part holds, from its `type` attribute or the file's version flags.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum PartType {
    Flat { tiled: bool },
    Deep { tiled: bool },
    Other(String),
}

/// One part: its attributes, in the file's order, and where each begins.
pub(super) struct RawPart {
    pub(super) index: usize,
    pub(super) offset: u64,
    pub(super) part_type: PartType,
    pub(super) attributes: Vec<(Attribute, u64)>,
}

/// Everything before the offset tables.
pub(super) struct FileParts {
    pub(super) parts: Vec<RawPart>,
    pub(super) multi_part: bool,
    /// Where the first part's offset table begins.
    pub(super) tables_offset: u64,
}

impl FileParts {
    pub(super) fn read(source: &mut ByteSource, limits: &Limits) -> Result<Self> {
        let flags = read_version(source)?;
        let mut scanner = Scanner { source, limits, position: 8 };
        let mut parts = Vec::new();
        loop {
            if flags.has_multiple_layers && scanner.list_ends()? {
                break;
            }
            if parts.len() as u64 >= u64::from(limits.max_parts) {
                return Err(Error::LimitExceeded {
                    place: format!("header at offset {}", scanner.position),
                    what: "number of parts",
                    value: parts.len() as u64 + 1,
                    limit: limits.max_parts.into(),
                });
            }
            parts.push(scanner.part(parts.len(), &flags)?);
            if !flags.has_multiple_layers {
                break;
            }
        }
        Ok(Self { parts, multi_part: flags.has_multiple_layers, tables_offset: scanner.position })
    }

    /// The part that is named, or the first deep one, or the first flat one with a
    /// depth channel; and what of the selection concerns its channels. A layer that
    /// no part has may be the name of one.
    pub(super) fn choose(
        &self,
        selection: &Selection,
        limits: &Limits,
    ) -> Result<(&RawPart, Selection)> {
        let named = |name: &str| self.parts.iter().find(|p| p.name().as_deref() == Some(name));
        if let Some(name) = &selection.part {
            let part = named(name)
                .ok_or_else(|| Error::NoSuchPart { name: name.clone(), parts: self.describe() })?;
            return Ok((part, selection.clone()));
        }
        let of_type = |is_deep: bool| {
            self.parts.iter().filter(move |part| match part.part_type {
                PartType::Deep { .. } => is_deep,
                PartType::Flat { .. } => !is_deep,
                PartType::Other(_) => false,
            })
        };
        let has_it = |part: &&RawPart| {
            let is_flat = matches!(part.part_type, PartType::Flat { .. });
            let names = part.channel_names();
            // Too many are refused when they are read.
            names.len() as u64 > u64::from(limits.max_channels)
                || !matches!(
                    ChannelChoice::find(&names, selection, is_flat),
                    Err(Refusal::Missing(_))
                )
        };
        let with_depth = of_type(true).find(has_it).or_else(|| of_type(false).find(has_it));
        if let Some(part) = with_depth {
            return Ok((part, selection.clone()));
        }
        if let Some(part) = selection.layer.as_deref().and_then(named) {
            return Ok((part, Selection { layer: None, ..selection.clone() }));
        }
        // What it lacks is said of the part that would be read.
        let is_wish = *selection != Selection::default();
        let first = of_type(true).next().or_else(|| of_type(false).next().filter(|_| is_wish));
        first.map(|part| (part, selection.clone())).ok_or_else(|| Error::NoDepth {
            reason: "neither a deep part nor a flat one with a channel Z",
            parts: self.describe(),
        })
    }

    /// The parts' names, types and channels, for messages.
    pub(super) fn describe(&self) -> String {
        const SHOWN: usize = 8;
        let mut text: Vec<_> = self.parts.iter().take(SHOWN).map(RawPart::describe).collect();
        if self.parts.len() > SHOWN {
            text.push(format!("{} more", self.parts.len() - SHOWN));
        }
        if text.is_empty() { "no parts".to_owned() } else { text.join(", ") }
    }
}

impl RawPart {
    pub(super) fn attribute(&self, name: &str) -> Option<(&Attribute, u64)> {
        let found = self.attributes.iter().find(|(a, _)| a.name == name.as_bytes());
        found.map(|(attribute, offset)| (attribute, *offset))
    }

    pub(super) fn name(&self) -> Option<String> {
        let (attribute, _) = self.attribute("name")?;
        (attribute.type_name == b"string")
            .then(|| String::from_utf8_lossy(&attribute.value).into_owned())
    }

    /// An error about the attribute `name` of this part.
    pub(super) fn error(&self, name: &str, reason: impl Into<String>) -> Error {
        Error::Header {
            part: self.index,
            attribute: name.to_owned(),
            offset: self.attribute(name).map_or(self.offset, |(_, offset)| offset),
            reason: reason.into(),
        }
    }

    /// Index and name, for messages.
    pub(super) fn title(&self) -> String {
        match self.name() {
            Some(name) => format!("{} '{name}'", self.index),
            None => self.index.to_string(),
        }
    }

    fn describe(&self) -> String {
        let kind = match &self.part_type {
            PartType::Flat { tiled: false } => "scanlineimage",
            PartType::Flat { tiled: true } => "tiledimage",
            PartType::Deep { tiled: false } => "deepscanline",
            PartType::Deep { tiled: true } => "deeptile",
            PartType::Other(name) => name,
        };
        format!("part {} ({kind}: {})", self.title(), self.list_channels())
    }

    /// The first of its channels, for messages.
    pub(super) fn list_channels(&self) -> String {
        const SHOWN: usize = 16;
        let mut channels = self.channel_names();
        if channels.len() > SHOWN {
            channels.truncate(SHOWN);
            channels.push("…".to_owned());
        }
        channels.join(" ")
    }

    /// As many channel names as can be made out.
    fn channel_names(&self) -> Vec<String> {
        let mut names = Vec::new();
        let mut rest = self.attribute("channels").map_or(&[][..], |(a, _)| &a.value);
        while let Some(end) = rest.iter().position(|&byte| byte == 0).filter(|&end| end > 0) {
            names.push(String::from_utf8_lossy(&rest[..end]).into_owned());
            rest = rest.get(end + 17..).unwrap_or_default();
        }
        names
    }
}

fn read_version(source: &mut ByteSource) -> Result<Requirements> {
    let start = source.slice(0, source.length().min(8), "magic number")?;
    if !start.starts_with(&magic_number::BYTES) {
        let hex: Vec<_> = start.iter().map(|byte| format!("{byte:02x}")).collect();
        let found = match start {
            [] => "the file is empty".to_owned(),
            [0x89, b'D', b'S', b'M', ..] => "it is a .dsm file".to_owned(),
            [b'I', b'I', 42, 0, ..] | [b'M', b'M', 0, 42, ..] => "it is a TIFF file".to_owned(),
            [0x89, b'P', b'N', b'G', ..] => "it is a PNG file".to_owned(),
            _ => format!("it starts with {}", hex.join(" ")),
        };
        return Err(Error::NotExr { found });
    }
    let mut version = source.slice(4, 4, "version")?;
    let word = u32::from_le_bytes([version[0], version[1], version[2], version[3]]);
    let unsupported = |reason| Error::UnsupportedVersion { reason };
    let flags = Requirements::read(&mut version)
        .map_err(|error| unsupported(format!("{error}, in version field {word:#010x}")))?;
    if word & 0xff != 2 && word & 0xff != 1 {
        return Err(unsupported(format!("version {}, known are 1 and 2", word & 0xff)));
    }
    Ok(flags)
}

/// Walks through the headers.
struct Scanner<'a> {
    source: &'a mut ByteSource,
    limits: &'a Limits,
    position: u64,
}

impl Scanner<'_> {
    /// Whether a zero byte ends the list that is being read; consumes it.
    fn list_ends(&mut self) -> Result<bool> {
        let ends = self.source.slice(self.position, 1, "header")? == [0];
        self.position += u64::from(ends);
        Ok(ends)
    }

    fn part(&mut self, index: usize, flags: &Requirements) -> Result<RawPart> {
        let offset = self.position;
        let mut names = HashSet::new();
        let mut part = RawPart {
            index,
            offset,
            part_type: PartType::Flat { tiled: false },
            attributes: Vec::new(),
        };
        while !self.list_ends()? {
            let offset = self.position;
            if part.attributes.len() as u64 >= u64::from(self.limits.max_attributes) {
                return Err(Error::LimitExceeded {
                    place: format!("header of part {index}, offset {offset}"),
                    what: "number of attributes",
                    value: part.attributes.len() as u64 + 1,
                    limit: self.limits.max_attributes.into(),
                });
            }
            let attribute = self.attribute(index)?;
            if !names.insert(attribute.name.clone()) {
                return Err(Error::Header {
                    part: index,
                    attribute: attribute.name_text().into_owned(),
                    offset,
                    reason: "appears twice".to_owned(),
                });
            }
            part.attributes.push((attribute, offset));
        }
        part.part_type = part_type(&part, flags);
        Ok(part)
    }

    fn attribute(&mut self, part: usize) -> Result<Attribute> {
        let offset = self.position;
        let refuse = |name: &[u8], reason: String| Error::Header {
            part,
            attribute: String::from_utf8_lossy(name).into_owned(),
            offset,
            reason,
        };
        let too_long = || format!("name longer than {LONGEST_NAME} bytes");
        let name = self.source.text(self.position, LONGEST_NAME as u64, "attribute name")?;
        let name = name.ok_or_else(|| refuse(b"?", too_long()))?;
        self.position += name.len() as u64 + 1;
        let type_name = self.source.text(self.position, LONGEST_NAME as u64, "attribute type")?;
        let type_name = type_name.ok_or_else(|| refuse(&name, too_long()))?;
        self.position += type_name.len() as u64 + 1;
        let size = self.source.slice(self.position, 4, "attribute size")?;
        let size = i32::from_le_bytes([size[0], size[1], size[2], size[3]]);
        self.position += 4;
        let size = u64::try_from(size).map_err(|_| refuse(&name, format!("size {size}")))?;
        let left = self.source.length() - self.position;
        if size > left {
            return Err(refuse(&name, format!("size {size}, but the file has {left} bytes more")));
        }
        if self.position + size > self.limits.max_header_bytes {
            return Err(Error::LimitExceeded {
                place: format!("header of part {part}, offset {offset}"),
                what: "length of the headers in bytes",
                value: self.position + size,
                limit: self.limits.max_header_bytes,
            });
        }
        let value = self.source.slice(self.position, size, "attribute value")?.to_vec();
        self.position += size;
        Ok(Attribute { name, type_name, value })
    }
}

/// Flat single-part files may lack the attribute, or carry a wrong one: there
/// the version flags decide.
fn part_type(part: &RawPart, flags: &Requirements) -> PartType {
    let from_flags = PartType::Flat { tiled: flags.is_single_layer_and_tiled };
    match part.attribute("type").map(|(attribute, _)| attribute.value.as_slice()) {
        Some(b"deepscanline") => PartType::Deep { tiled: false },
        Some(b"deeptile") => PartType::Deep { tiled: true },
        _ if !flags.has_multiple_layers && !flags.has_deep_data => from_flags,
        Some(b"scanlineimage") => PartType::Flat { tiled: false },
        Some(b"tiledimage") => PartType::Flat { tiled: true },
        Some(other) => PartType::Other(String::from_utf8_lossy(other).into_owned()),
        None => PartType::Other("no type".to_owned()),
    }
}
