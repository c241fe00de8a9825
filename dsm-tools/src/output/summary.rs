//! What `inspect` tells of a map.

use std::collections::BTreeMap;
use std::io::{self, Write};

use dsm_core::{
    DepthKind, Filter, LightExtent, PixelWindow, ShadowCamera, Transmittance, VisibilityView,
};
use dsm_io::{Attribute, Block, Codec, Container, Level, Metadata, TileDirectory, TileEntry};
use serde::Serialize;

use super::layers::{LayersOfPixel, LayersSummary};
use super::printable;

/// A map's metadata and levels, and one of its pixels.
#[derive(Serialize)]
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
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) layers: Option<LayersSummary>,
    #[serde(flatten)]
    pub(crate) pixel: Option<PixelSummary>,
    #[serde(flatten)]
    pub(crate) layers_of_pixel: Option<LayersOfPixel>,
}

/// What depths measure, and between which all vertices of level 0 lie.
#[derive(Serialize)]
struct DepthSummary {
    kind: DepthKind,
    min: Option<f32>,
    max: Option<f32>,
}

#[derive(Serialize)]
struct LevelSummary {
    width: u32,
    height: u32,
    tolerance: f32,
    max_error: f32,
    mean_error: f32,
    vertices: u64,
    /// Bytes that the tiles take in the file.
    bytes: u64,
}

/// One pixel's visibility function.
#[derive(Serialize)]
pub(crate) struct PixelSummary {
    x: u32,
    y: u32,
    level: u32,
    /// Depth, V just before it, and V at it.
    vertices: Vec<(f32, Light, Light)>,
}

/// A value of V.
#[derive(Clone, Copy, Serialize)]
#[serde(untagged)]
pub(super) enum Light {
    Mono(f32),
    Rgb([f32; 3]),
}

impl<'a> Summary<'a> {
    /// Reads the directories of all levels, but no tile.
    pub(crate) fn new(
        kind: &'static str,
        metadata: &'a Metadata,
        container: &Container,
    ) -> dsm_io::Result<Self> {
        let info = &metadata.info;
        let directory = container.directory(0)?;
        let levels = (0..)
            .zip(container.levels())
            .map(|(index, level)| Ok(LevelSummary::new(level, container.directory(index)?)))
            .collect::<dsm_io::Result<_>>()?;
        let stored = || directory.iter().map(|(_, tile)| tile).filter(|tile| !tile.is_empty());
        Ok(Self {
            kind,
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
                |tag| Block::from_tag(tag).map(Block::name),
            ),
            tile: container.levels()[0].tile_width,
            tolerance: info.tolerance.epsilon(),
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
            layers: None,
            pixel: None,
            layers_of_pixel: None,
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
        if let Some(samples) = self.samples {
            line("samples", format!("{samples} a pixel"))?;
        }
        if let Some(filter) = self.filter {
            line("filter", format!("{}, {} pixels wide", filter.shape().name(), filter.width()))?;
        }
        if let Some(LightExtent { shape, size: [width, height] }) = self.light {
            line("light", format!("{}, {width} × {height}", shape.name()))?;
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
        if let Some(layers) = &self.layers {
            layers.write_text(output)?;
        }
        self.write_levels(output)?;
        self.write_attributes(output)?;
        if let Some(pixel) = &self.layers_of_pixel {
            pixel.write_text(output)?;
        }
        self.pixel.as_ref().map_or(Ok(()), |pixel| pixel.write_text(output))
    }

    fn write_levels(&self, output: &mut impl Write) -> io::Result<()> {
        writeln!(
            output,
            "\n  level           size    tolerance  max error  mean error      vertices         bytes"
        )?;
        for (index, level) in self.levels.iter().enumerate() {
            let size = format!("{} × {}", level.width, level.height);
            writeln!(
                output,
                "  {index:>5}{size:>15}{:>13}{:>11.2e}{:>12.2e}{:>14}{:>14}",
                level.tolerance, level.max_error, level.mean_error, level.vertices, level.bytes
            )?;
        }
        Ok(())
    }

    fn write_attributes(&self, output: &mut impl Write) -> io::Result<()> {
        if self.attributes.is_empty() {
            return Ok(());
        }
        let width = self.attributes.keys().map(|name| name.chars().count()).max().unwrap_or(0);
        writeln!(output, "\n  attributes")?;
        for (name, attribute) in self.attributes {
            let value = match attribute.as_text() {
                Some(text) => text.to_owned(),
                None => serde_json::to_string(attribute)?,
            };
            let shown: String = printable(&value).chars().take(100).collect();
            writeln!(output, "    {:<width$}  {shown}", printable(name))?;
        }
        Ok(())
    }
}

impl LevelSummary {
    fn new(level: &Level, directory: &TileDirectory) -> Self {
        let tiles = || directory.iter().map(|(_, tile)| tile);
        Self {
            width: level.width,
            height: level.height,
            tolerance: level.tolerance,
            max_error: level.error.max,
            mean_error: level.error.mean,
            vertices: tiles().map(|tile| tile.vertex_count).sum(),
            bytes: tiles().map(|tile| tile.stored_length).sum(),
        }
    }
}

impl PixelSummary {
    /// The function of pixel (`x`, `y`) of a level. The two vertices of a step
    /// make one entry.
    pub(crate) fn new<T: Transmittance>(
        level: u32,
        [x, y]: [u32; 2],
        function: VisibilityView<'_, T>,
    ) -> Self {
        let mut vertices: Vec<(f32, Light, Light)> = Vec::with_capacity(function.len());
        for vertex in function.vertices() {
            let light = Light::of(vertex.value);
            match vertices.last_mut() {
                Some((z, _, after)) if *z == vertex.z => *after = light,
                _ => vertices.push((vertex.z, light, light)),
            }
        }
        Self { x, y, level, vertices }
    }

    fn write_text(&self, output: &mut impl Write) -> io::Result<()> {
        let Self { x, y, level, vertices } = self;
        let of_level = if *level == 0 { String::new() } else { format!(" of level {level}") };
        writeln!(output, "\n  pixel ({x}, {y}){of_level}")?;
        if vertices.is_empty() {
            return writeln!(output, "    no vertices: lit at every depth");
        }
        let column = vertices.first().map_or(12, |(_, before, _)| before.width());
        writeln!(output, "    {:>14}  {:<column$}  V at and behind", "depth", "V before")?;
        for (z, before, after) in vertices {
            writeln!(output, "    {z:>14}  {:<column$}  {}", before.text(), after.text())?;
        }
        Ok(())
    }
}

impl Light {
    pub(super) fn of<T: Transmittance>(value: T) -> Self {
        if T::CHANNELS == 1 {
            Self::Mono(value.channel(0))
        } else {
            Self::Rgb([0, 1, 2].map(|channel| value.channel(channel)))
        }
    }

    pub(super) fn text(self) -> String {
        match self {
            Self::Mono(value) => value.to_string(),
            Self::Rgb(values) => values.map(|value| format!("{value:<12}")).concat(),
        }
    }

    const fn width(self) -> usize {
        match self {
            Self::Mono(_) => 12,
            Self::Rgb(_) => 36,
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use dsm_core::{Rgb, Vertex, VisibilityFunction};

    fn json<T: Transmittance>(vertices: &[(f32, T)]) -> String {
        let vertices = vertices.iter().map(|&(z, value)| Vertex::new(z, value));
        let function = VisibilityFunction::new(vertices).unwrap();
        serde_json::to_string(&PixelSummary::new(0, [3, 4], function.view())).unwrap()
    }

    #[test]
    fn a_step_is_one_entry() {
        assert_eq!(
            json(&[(1.0, 1.0), (1.0, 0.8), (2.0, 0.8), (4.5, 0.1_f32)]),
            r#"{"x":3,"y":4,"level":0,"vertices":[[1.0,1.0,0.8],[2.0,0.8,0.8],[4.5,0.1,0.1]]}"#
        );
        assert_eq!(
            json(&[(1.0, Rgb::CLEAR), (1.0, Rgb::new(0.5, 0.25, 0.0))]),
            r#"{"x":3,"y":4,"level":0,"vertices":[[1.0,[1.0,1.0,1.0],[0.5,0.25,0.0]]]}"#
        );
        assert_eq!(json::<f32>(&[]), r#"{"x":3,"y":4,"level":0,"vertices":[]}"#);
    }
}
