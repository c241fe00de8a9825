//! What `inspect` tells of an OpenEXR: its parts, and what their samples are.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::Path;

use anyhow::{Context, Result};
use deepshadow::files::Limits;
use deepshadow::files::deep_exr::{AlphaChannels, DeepExrReader, Selection};
use exr::meta::BlockDescription;
use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, IntegerBounds, SampleType};
use exr::meta::header::Header;
use serde::Serialize;

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

/// What the samples of a part are.
#[derive(Serialize)]
struct Samples {
    total: u64,
    max_per_pixel: u64,
    empty_pixels: u64,
    /// Samples that reach from a depth to another.
    volumes: u64,
    /// The channels that depth and opacity are read from.
    read: Vec<String>,
    alpha: &'static str,
    /// Least and largest of what is finite.
    depth: Option<[f32; 2]>,
    opacity: Option<[f32; 2]>,
    /// Samples of which a number is not finite.
    not_finite: u64,
}

/// The samples of a pixel as the file has them.
#[derive(Serialize)]
struct PixelSamples {
    x: u32,
    y: u32,
    /// Front, back and opacity of each channel.
    samples: Vec<(f32, f32, [f32; 3])>,
}

impl ImageSummary {
    /// Reads the headers and all samples, and those of a pixel of the data window. O(samples);
    /// holds a row.
    pub(crate) fn new(path: &Path, pixel: Option<[u32; 2]>) -> Result<Self> {
        let in_file = || path.display().to_string();
        let meta = MetaData::read_from_file(path, false).with_context(in_file)?;
        let several = meta.headers.len() > 1;
        let mut parts = Vec::new();
        let mut found = None;
        for header in &meta.headers {
            let name = header.own_attributes.layer_name.as_ref().map(ToString::to_string);
            let chosen = name.as_deref().filter(|_| several);
            let mut part = Part::new(header, name.clone());
            match DeepExrReader::open(path, Selection::from(chosen), &Limits::default().images) {
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

impl Samples {
    fn count(reader: &mut DeepExrReader) -> Result<Self> {
        let header = reader.header().clone();
        let mut counted = Self {
            total: 0,
            max_per_pixel: 0,
            empty_pixels: 0,
            volumes: 0,
            read: header
                .channels
                .iter()
                .filter(|channel| header.read.contains(&channel.name))
                .map(|channel| printable(&channel.name))
                .collect(),
            alpha: match header.alpha {
                AlphaChannels::None => "none: opaque",
                AlphaChannels::Mono => "one",
                AlphaChannels::Colour => "one a colour",
            },
            depth: None,
            opacity: None,
            not_finite: 0,
        };
        for y in 0..header.height {
            let rows = reader.read_rows(y..y + 1)?;
            for pixel in 0..rows.pixel_count() {
                let samples = rows.pixel(pixel);
                counted.total += samples.len() as u64;
                counted.max_per_pixel = counted.max_per_pixel.max(samples.len() as u64);
                counted.empty_pixels += u64::from(samples.is_empty());
            }
            for index in 0..rows.sample_count() {
                let sample = rows.sample(index);
                counted.volumes += u64::from(sample.z_back > sample.z);
                widen(&mut counted.depth, &[sample.z, sample.z_back]);
                widen(&mut counted.opacity, &sample.alpha);
                let all = sample.alpha.iter().chain([&sample.z, &sample.z_back]);
                counted.not_finite += u64::from(!all.copied().all(f32::is_finite));
            }
        }
        Ok(counted)
    }

    fn lines(&self) -> Vec<(&'static str, String)> {
        let range = |range: Option<[f32; 2]>| {
            range.map_or_else(|| "none".to_owned(), |[least, most]| format!("{least} to {most}"))
        };
        let Self { total, max_per_pixel, empty_pixels, volumes, .. } = self;
        let mut lines = vec![
            (
                "samples",
                format!(
                    "{total}, at most {max_per_pixel} a pixel, {volumes} of them volumes; \
                     {empty_pixels} empty pixels"
                ),
            ),
            ("read", format!("{} (alpha: {})", self.read.join(", "), self.alpha)),
            ("depth", range(self.depth)),
            ("opacity", range(self.opacity)),
        ];
        if self.not_finite > 0 {
            lines.push(("not finite", format!("{} samples", self.not_finite)));
        }
        lines
    }
}

fn widen(range: &mut Option<[f32; 2]>, values: &[f32]) {
    for &value in values.iter().filter(|value| value.is_finite()) {
        let [least, most] = range.unwrap_or([value; 2]);
        *range = Some([least.min(value), most.max(value)]);
    }
}

impl PixelSamples {
    fn read(reader: &mut DeepExrReader, [x, y]: [u32; 2]) -> Result<Self> {
        let [width, height] = [reader.header().width, reader.header().height];
        anyhow::ensure!(
            x < width && y < height,
            "pixel ({x}, {y}) lies outside the image of {width} × {height} pixels"
        );
        let rows = reader.read_rows(y..y + 1)?;
        let samples = rows.pixel(x as usize).map(|index| rows.sample(index));
        let samples = samples.map(|sample| (sample.z, sample.z_back, sample.alpha)).collect();
        Ok(Self { x, y, samples })
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
