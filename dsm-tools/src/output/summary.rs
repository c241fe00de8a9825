//! What `inspect` tells of a map.

use std::collections::BTreeMap;
use std::io::{self, Write};

use deepshadow::ShadowMap;
use deepshadow::detail::StatedError;
use deepshadow::files::detail::{Level, PixelValue, SummaryValue, TileDirectory, TileEntry};
use deepshadow::files::{Attribute, Codec, MapSummary, Packing, PixelContents};
use deepshadow::visibility::detail::{DepthKind, PixelWindow};
use deepshadow::visibility::{Compression, Filter, LightExtent, ShadowCamera, Side};
use serde::ser::{Serialize, SerializeMap, Serializer};
use serde_json::Value;

use super::printable;
use super::stated::StatedReport;

/// A map's metadata and levels, and one of its pixels.
#[derive(serde::Serialize)]
pub(crate) struct Summary<'a> {
    kind: &'static str,
    width: u32,
    height: u32,
    channels: u8,
    codec: String,
    block: String,
    /// Width of a tile, in pixels.
    tile: u32,
    tolerance: f32,
    /// How its functions were compressed, where it says so.
    #[serde(skip_serializing_if = "Option::is_none")]
    compression: Option<Compression>,
    samples: Option<u32>,
    filter: Option<Filter>,
    depth: DepthSummary,
    camera: Option<ShadowCamera>,
    light: Option<LightExtent>,
    data_window: Option<PixelWindow>,
    display_window: Option<PixelWindow>,
    software: &'a str,
    levels: Vec<LevelSummary>,
    attributes: &'a BTreeMap<String, Attribute>,
    /// What its tiles hold together.
    contents: MapSummary,
    /// The keys that only maps of its kind have.
    #[serde(flatten)]
    keys: Value,
    #[serde(flatten)]
    pub(crate) pixel: Option<PixelSummary>,
}

/// What depths measure, and between which all vertices of level 0 lie.
#[derive(serde::Serialize)]
struct DepthSummary {
    kind: DepthKind,
    min: Option<f32>,
    max: Option<f32>,
}

#[derive(serde::Serialize)]
struct LevelSummary {
    width: u32,
    height: u32,
    tolerance: f32,
    #[serde(flatten)]
    stated: StatedReport,
    vertices: u64,
    /// Bytes that the tiles take in the file.
    bytes: u64,
}

/// What is stored of one pixel.
pub(crate) struct PixelSummary {
    x: u32,
    y: u32,
    level: u32,
    contents: PixelContents,
}

impl Serialize for PixelSummary {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(4))?;
        map.serialize_entry("x", &self.x)?;
        map.serialize_entry("y", &self.y)?;
        map.serialize_entry("level", &self.level)?;
        map.serialize_entry(self.contents.name(), &self.contents)?;
        map.end()
    }
}

impl<'a> Summary<'a> {
    /// Reads the directories of all levels, and what the map's kind sums up.
    pub(crate) fn new(map: &'a ShadowMap) -> deepshadow::detail::Result<Self> {
        let (metadata, container) = (map.metadata(), map.container());
        let info = &metadata.info;
        let directory = container.directory(0)?;
        let levels = (0..)
            .zip(container.levels())
            .zip(map.stated_errors()?)
            .map(|((index, level), stated)| {
                Ok(LevelSummary::new(level, stated, container.directory(index)?))
            })
            .collect::<deepshadow::files::detail::Result<_>>()?;
        let stored = || directory.iter().map(|(_, tile)| tile).filter(|tile| !tile.is_empty());
        Ok(Self {
            kind: map.kind(),
            width: metadata.width,
            height: metadata.height,
            channels: metadata.channels,
            codec: encoding(
                stored(),
                |tile| tile.codec,
                |tag| Codec::from_tag(tag).map(Codec::name),
            ),
            block: encoding(
                stored(),
                |tile| tile.block,
                |tag| Packing::from_tag(tag).map(Packing::name),
            ),
            tile: container.levels()[0].tile_width,
            tolerance: info.tolerance.epsilon(),
            compression: info.compression,
            samples: info.samples,
            filter: info.filter,
            depth: DepthSummary {
                kind: info.depth_kind,
                min: stored().map(|tile| tile.z_min).reduce(f32::min),
                max: stored().map(|tile| tile.z_max).reduce(f32::max),
            },
            camera: info.camera,
            light: info.light,
            data_window: info.data_window,
            display_window: info.display_window,
            software: &metadata.software,
            levels,
            attributes: &metadata.attributes,
            contents: map.summary()?,
            keys: map.kind_metadata()?,
            pixel: None,
        })
    }

    /// Writes the summary for people.
    pub(crate) fn write_text(&self, output: &mut impl Write) -> io::Result<()> {
        let mut line = |name: &str, value: String| writeln!(output, "  {name:<12}{value}");
        let Self { width, height, channels, codec, block, tile, .. } = self;
        let plural = if *channels == 1 { "" } else { "s" };
        line("kind", self.kind.to_owned())?;
        line("size", format!("{width} × {height} pixels, {channels} channel{plural}"))?;
        line("stored", format!("{codec}, block {block}, tiles of {tile} pixels"))?;
        line("tolerance", self.tolerance.to_string())?;
        if let Some(compression) = self.compression {
            let side = match compression.side {
                Side::Both => "",
                Side::Lighter => ", nowhere darker",
                Side::Darker => ", nowhere lighter",
            };
            line("compression", format!("{}{side}", compression.method.name()))?;
        }
        if let Some(samples) = self.samples {
            line("samples", format!("{samples} a pixel"))?;
        }
        if let Some(filter) = self.filter {
            line("filter", format!("{}, {} pixels wide", filter.shape().name(), filter.width()))?;
        }
        if let Some(light) = self.light {
            let [width, height] = light.size().map(|size| size as f32);
            line("light", format!("{}, {width} × {height}", light.shape().name()))?;
        }
        let kind = match self.depth.kind {
            DepthKind::Planar => "planar",
            _ => "of another kind",
        };
        let range = match (self.depth.min, self.depth.max) {
            (Some(min), Some(max)) => format!("{min} to {max}"),
            _ => "no vertices".to_owned(),
        };
        line("depth", format!("{kind}, {range}"))?;
        if let Some(camera) = self.camera {
            let matrices = [("to camera", camera.world_to_camera), ("to NDC", camera.world_to_ndc)];
            for (name, matrix) in matrices {
                let Some(matrix) = matrix else {
                    line(name, "unknown".to_owned())?;
                    continue;
                };
                for row in 0..4 {
                    let numbers =
                        matrix.row(row).to_array().map(|number| format!("{number:>12.6}"));
                    line(if row == 0 { name } else { "" }, numbers.concat())?;
                }
            }
        } else {
            line("camera", "unknown".to_owned())?;
        }
        for (name, window) in [("data", self.data_window), ("display", self.display_window)] {
            if let Some(PixelWindow { min, max }) = window {
                let corners = format!("({}, {}) to ({}, {})", min[0], min[1], max[0], max[1]);
                line(name, format!("window {corners}"))?;
            }
        }
        line("software", printable(self.software))?;
        for (name, value) in self.keys.as_object().into_iter().flatten() {
            line(name, printable(&value.to_string()))?;
        }
        self.write_contents(output)?;
        self.write_levels(output)?;
        self.write_attributes(output)?;
        self.pixel.as_ref().map_or(Ok(()), |pixel| pixel.write_text(output))
    }

    fn write_contents(&self, output: &mut impl Write) -> io::Result<()> {
        writeln!(output, "\n  contents")?;
        let width = self.contents.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
        for (name, value) in self.contents.iter() {
            let shown = match value {
                SummaryValue::Counts(counts) => {
                    counts.iter().map(u64::to_string).collect::<Vec<_>>().join(", ")
                }
                SummaryValue::Count(count) => count.to_string(),
                _ => continue,
            };
            writeln!(output, "    {:<width$}  {shown}", name.replace('_', " "))?;
        }
        Ok(())
    }

    fn write_levels(&self, output: &mut impl Write) -> io::Result<()> {
        writeln!(
            output,
            "\n  level           size    tolerance  max error  mean error  depth error  at a depth  \
                 vertices         bytes"
        )?;
        for (index, level) in self.levels.iter().enumerate() {
            let size = format!("{} × {}", level.width, level.height);
            writeln!(
                output,
                "  {index:>5}{size:>15}{:>13}{}{:>14}{:>14}",
                level.tolerance,
                level.stated.columns(),
                level.vertices,
                level.bytes
            )?;
        }
        Ok(())
    }

    fn write_attributes(&self, output: &mut impl Write) -> io::Result<()> {
        if self.attributes.is_empty() {
            return Ok(());
        }
        const WIDEST: usize = 100;
        let shown = |text: &str| printable(text).chars().take(WIDEST).collect::<String>();
        let names = self.attributes.keys().map(|name| name.chars().count().min(WIDEST));
        let width = names.max().unwrap_or(0);
        writeln!(output, "\n  attributes")?;
        for (name, attribute) in self.attributes {
            let value = match attribute.as_text() {
                Some(text) => text.to_owned(),
                None => serde_json::to_string(attribute)?,
            };
            writeln!(output, "    {:<width$}  {}", shown(name), shown(&value))?;
        }
        Ok(())
    }
}

impl LevelSummary {
    fn new(level: &Level, stated: StatedError, directory: &TileDirectory) -> Self {
        let tiles = || directory.iter().map(|(_, tile)| tile);
        Self {
            width: level.width,
            height: level.height,
            tolerance: level.tolerance,
            stated: stated.into(),
            vertices: tiles().map(|tile| tile.vertex_count).fold(0, u64::saturating_add),
            bytes: tiles().map(|tile| tile.stored_length).fold(0, u64::saturating_add),
        }
    }
}

impl PixelSummary {
    pub(crate) const fn new(level: u32, [x, y]: [u32; 2], contents: PixelContents) -> Self {
        Self { x, y, level, contents }
    }

    fn write_text(&self, output: &mut impl Write) -> io::Result<()> {
        let Self { x, y, level, contents } = self;
        let of_level = if *level == 0 { String::new() } else { format!(" of level {level}") };
        writeln!(output, "\n  pixel ({x}, {y}){of_level}")?;
        if contents.rows().is_empty() {
            return writeln!(output, "    no {}: lit at every depth", contents.name());
        }
        let shown = |value: &PixelValue| match value {
            PixelValue::Number(number) => number.to_string(),
            PixelValue::Count(count) => count.to_string(),
            PixelValue::Rgb(values) => values.map(|value| format!("{value:<12}")).concat(),
            PixelValue::Mask(mask) => format!("{mask:#018x}"),
            _ => String::new(),
        };
        for (number, list) in contents.lists().enumerate() {
            if contents.has_lists() {
                writeln!(output, "    {} {number}", contents.name())?;
            }
            let rows: Vec<Vec<String>> =
                list.iter().map(|row| row.iter().map(shown).collect()).collect();
            let header = contents.columns().iter().map(|name| (*name).to_owned()).collect();
            for row in [header].iter().chain(&rows) {
                write!(output, "    {:>14}", row.first().map_or("", String::as_str))?;
                for (column, cell) in row.iter().enumerate().skip(1) {
                    let cells = rows.iter().filter_map(|row| row.get(column));
                    let width = cells.map(|cell| cell.chars().count()).max().unwrap_or(0).max(10);
                    write!(output, "  {cell:<width$}")?;
                }
                writeln!(output)?;
            }
        }
        Ok(())
    }
}

/// The name of the tiles' encoding. Tiles that packing didn't make smaller
/// are plain among packed ones: the highest number stands for all.
fn encoding<'a>(
    tiles: impl Iterator<Item = &'a TileEntry>,
    tag: impl Fn(&TileEntry) -> u8,
    name: impl Fn(u8) -> Option<&'static str>,
) -> String {
    let highest = tiles.map(tag).max().unwrap_or(0);
    name(highest).map_or_else(|| format!("unknown ({highest})"), str::to_owned)
}
