//! What `inspect` tells of an OpenEXR: its parts, and what their samples are.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::Path;

use anyhow::{Context, Result};
use deepshadow::files::Limits;
use deepshadow::files::deep_exr::{
    ChannelType, DeepExrReader, Header as ReadHeader, Layout, Selection, Window,
};
use exr::meta::BlockDescription;
use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, IntegerBounds, SampleType};
use exr::meta::header::Header;
use serde::Serialize;

use super::image_samples::{PixelSamples, Samples};
use super::printable;

/// An image, part by part.
#[derive(Serialize)]
pub(crate) struct ImageSummary {
    format: &'static str,
    parts: Vec<Part>,
    /// The samples of the pixel that was asked for, of the first part that has any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pixel: Option<PixelSamples>,
}

#[derive(Serialize)]
struct Part {
    name: Option<String>,
    r#type: &'static str,
    width: u64,
    height: u64,
    compression: String,
    data_window: Bounds,
    display_window: Bounds,
    channels: Vec<ChannelSummary>,
    /// Matrices for row vectors, as the file has them.
    world_to_camera: Option<[f32; 16]>,
    world_to_ndc: Option<[f32; 16]>,
    attributes: BTreeMap<String, String>,
    samples: Option<Samples>,
    /// Why its samples make no map.
    no_samples: Option<String>,
}

/// Corners that both belong to the window.
#[derive(Serialize)]
struct Bounds {
    min: [i64; 2],
    max: [i64; 2],
}

#[derive(Serialize)]
struct ChannelSummary {
    name: String,
    r#type: &'static str,
}

impl ImageSummary {
    /// Reads the headers and all samples, and those of a pixel of the data window. O(samples);
    /// holds a row.
    pub(crate) fn new(path: &Path, pixel: Option<[u32; 2]>) -> Result<Self> {
        let in_file = || path.display().to_string();
        let limits = Limits::default().images;
        // That reader does not know all compressions; what it cannot read may be one part that is.
        let meta = match MetaData::read_from_file(path, false) {
            Ok(meta) => meta,
            Err(error) => {
                let Ok(mut reader) = DeepExrReader::open(path, None, &limits) else {
                    return Err(error).with_context(in_file);
                };
                return Self::of_readable(&mut reader, pixel).with_context(in_file);
            }
        };
        let several = meta.headers.len() > 1;
        let mut parts = Vec::new();
        let mut found = None;
        for header in &meta.headers {
            let name = header.own_attributes.layer_name.as_ref().map(ToString::to_string);
            let chosen = name.as_deref().filter(|_| several);
            let mut part = Part::new(header, name.clone());
            match DeepExrReader::open(path, Selection::from(chosen), &limits) {
                Ok(mut reader) => {
                    part.samples = Some(Samples::count(&mut reader).with_context(in_file)?);
                    if let (Some(at), None) = (pixel, &found) {
                        found = Some(PixelSamples::read(&mut reader, at).with_context(in_file)?);
                    }
                }
                Err(error) => part.no_samples = Some(printable(&error.to_string())),
            }
            parts.push(part);
        }
        Ok(Self { format: "openexr", parts, pixel: found })
    }

    /// The part that a reader has opened.
    fn of_readable(reader: &mut DeepExrReader, pixel: Option<[u32; 2]>) -> Result<Self> {
        let mut part = Part::of_readable(reader.header());
        part.samples = Some(Samples::count(reader)?);
        let pixel = pixel.map(|at| PixelSamples::read(reader, at)).transpose()?;
        Ok(Self { format: "openexr", parts: vec![part], pixel })
    }

    /// Writes the summary for people.
    pub(crate) fn write_text(&self, output: &mut impl Write) -> io::Result<()> {
        for (index, part) in self.parts.iter().enumerate() {
            part.write_text(index, output)?;
        }
        let Some(PixelSamples { x, y, samples }) = &self.pixel else { return Ok(()) };
        writeln!(output, "\n  pixel ({x}, {y}) of the data window")?;
        if samples.is_empty() {
            return writeln!(output, "    no samples: lit at every depth");
        }
        writeln!(output, "    {:>14}  {:<12}  opacity", "depth", "to depth")?;
        for (front, back, opacity) in samples {
            writeln!(output, "    {front:>14}  {back:<12}  {opacity:?}")?;
        }
        Ok(())
    }
}

impl Part {
    fn new(header: &Header, name: Option<String>) -> Self {
        let is_tiled = matches!(header.blocks, BlockDescription::Tiles(_));
        let own = &header.own_attributes;
        let corner = own.layer_position;
        let size = header.layer_size;
        let data = IntegerBounds::new(corner, size);
        let named = own.other.iter().chain(&header.shared_attributes.other);
        Self {
            name,
            r#type: match (header.deep, is_tiled) {
                (true, true) => "deep tiles",
                (true, false) => "deep scan lines",
                (false, true) => "flat tiles",
                (false, false) => "flat scan lines",
            },
            width: size.0 as u64,
            height: size.1 as u64,
            compression: header.compression.to_string(),
            data_window: Bounds::of(data),
            display_window: Bounds::of(header.shared_attributes.display_window),
            channels: header
                .channels
                .list
                .iter()
                .map(|channel| ChannelSummary {
                    name: printable(&channel.name.to_string()),
                    r#type: match channel.sample_type {
                        SampleType::F16 => "half",
                        SampleType::F32 => "float",
                        SampleType::U32 => "uint",
                    },
                })
                .collect(),
            world_to_camera: own.world_to_camera,
            world_to_ndc: own.world_to_normalized_device,
            attributes: named
                .map(|(name, value)| (printable(&name.to_string()), attribute_text(value)))
                .collect(),
            samples: None,
            no_samples: None,
        }
    }

    fn of_readable(header: &ReadHeader) -> Self {
        let corners = |window: Window| {
            let Window { min, max } = window;
            Bounds { min: min.map(i64::from), max: max.map(i64::from) }
        };
        let types = header.channels.iter().map(|channel| ChannelSummary {
            name: printable(&channel.name),
            r#type: match channel.channel_type {
                ChannelType::Half => "half",
                ChannelType::Float => "float",
                ChannelType::Uint => "uint",
            },
        });
        Self {
            name: header.part_name.clone(),
            r#type: match (header.deep, matches!(header.layout, Layout::ScanLines)) {
                (true, false) => "deep tiles",
                (true, true) => "deep scan lines",
                (false, false) => "flat tiles",
                (false, true) => "flat scan lines",
            },
            width: header.width.into(),
            height: header.height.into(),
            compression: header.compression.to_owned(),
            data_window: corners(header.data_window),
            display_window: corners(header.display_window),
            channels: types.collect(),
            world_to_camera: header.world_to_camera,
            world_to_ndc: header.world_to_ndc,
            attributes: header
                .attributes
                .iter()
                .map(|attribute| {
                    let kind = String::from_utf8_lossy(&attribute.type_name);
                    let text = format!("{} bytes of type {kind}", attribute.value.len());
                    (printable(&attribute.name_text()), printable(&text))
                })
                .collect(),
            samples: None,
            no_samples: None,
        }
    }

    fn write_text(&self, index: usize, output: &mut impl Write) -> io::Result<()> {
        let name = self.name.as_ref().map(|name| format!(" \"{}\"", printable(name)));
        writeln!(output, "  part {index}{}: {}", name.unwrap_or_default(), self.r#type)?;
        let mut line = |name: &str, value: String| writeln!(output, "    {name:<12}{value}");
        line("size", format!("{} × {} pixels", self.width, self.height))?;
        line("compression", self.compression.clone())?;
        for (name, window) in [("data", &self.data_window), ("display", &self.display_window)] {
            let Bounds { min, max } = window;
            line(name, format!("window ({}, {}) to ({}, {})", min[0], min[1], max[0], max[1]))?;
        }
        let channels =
            self.channels.iter().map(|channel| format!("{} ({})", channel.name, channel.r#type));
        line("channels", channels.collect::<Vec<_>>().join(", "))?;
        for (name, matrix) in [("to camera", self.world_to_camera), ("to NDC", self.world_to_ndc)] {
            match matrix {
                None => line(name, "unknown".to_owned())?,
                Some(matrix) => {
                    for (row, numbers) in matrix.chunks_exact(4).enumerate() {
                        let numbers: String =
                            numbers.iter().map(|number| format!("{number:>12.6}")).collect();
                        line(if row == 0 { name } else { "" }, numbers)?;
                    }
                }
            }
        }
        match (&self.samples, &self.no_samples) {
            (Some(samples), _) => {
                samples.lines().into_iter().try_for_each(|(name, value)| line(name, value))?
            }
            (None, Some(reason)) => line("samples", format!("make no map: {reason}"))?,
            (None, None) => {}
        }
        for (name, value) in &self.attributes {
            line(name, value.clone())?;
        }
        Ok(())
    }
}

impl Bounds {
    fn of(bounds: IntegerBounds) -> Self {
        let min = [bounds.position.0, bounds.position.1].map(i64::from);
        let size = [bounds.size.0, bounds.size.1].map(|side| side as i64);
        Self { min, max: [0, 1].map(|axis| min[axis] + size[axis] - 1) }
    }
}

/// An attribute's value in a line; of what is long, its beginning.
fn attribute_text(value: &AttributeValue) -> String {
    const LONGEST: usize = 100;
    let text = match value {
        AttributeValue::Text(text) => text.to_string(),
        AttributeValue::F32(number) => number.to_string(),
        AttributeValue::F64(number) => number.to_string(),
        AttributeValue::I32(number) => number.to_string(),
        AttributeValue::Matrix4x4(numbers) => format!("{numbers:?}"),
        AttributeValue::FloatVec2(vector) => format!("{} {}", vector.0, vector.1),
        AttributeValue::FloatVec3(vector) => format!("{vector:?}"),
        AttributeValue::Custom { kind, bytes } => format!("{} bytes of type {kind}", bytes.len()),
        other => format!("{other:?}"),
    };
    printable(&text).chars().take(LONGEST).collect()
}
