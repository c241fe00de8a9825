//! `inspect`: what a map says of itself, and what is in it.

use std::io::{self, BufWriter, Write};
use std::path::Path;

use anyhow::{Context, Result, bail};
use deepshadow::ShadowMap;
use deepshadow::files::detail::AnyDeepMap;
use deepshadow::files::detail::{Level, TileRect, replace_file};
use deepshadow::visibility::Transmittance;
use deepshadow::visibility::detail::VisibilityView;

use crate::args::{ImageFile, ImageFormat, Inspect, SliceFile};
use crate::output::plot;
use crate::output::slice::Slice;
use crate::output::summary::{PixelSummary, Summary};

pub(crate) fn run(request: &Inspect) -> Result<()> {
    let map = ShadowMap::open(&request.file)?;
    let mut summary = Summary::new(&map)?;
    if let Some(pixel) = request.pixel {
        summary.pixel = Some(inspect_pixel(&map, pixel, request)?);
    }
    if let Some(file) = &request.slice {
        write_slice(&map, file)?;
    }
    print(&summary, request)
}

fn print(summary: &Summary<'_>, request: &Inspect) -> Result<()> {
    let mut output = BufWriter::new(io::stdout().lock());
    if request.json {
        serde_json::to_writer(&mut output, summary).map_err(io::Error::from)?;
        writeln!(output)?;
    } else {
        writeln!(output, "{}", request.file.display())?;
        summary.write_text(&mut output)?;
    }
    Ok(output.flush()?)
}

/// The visibility functions of some pixels.
fn functions(map: &ShadowMap, level: u32, rect: TileRect) -> Result<AnyDeepMap> {
    let found = map.functions(level, rect)?;
    found.with_context(|| {
        format!("a map of kind {} has no visibility functions to draw", map.kind())
    })
}

/// What is stored of a pixel, and its function plotted if that is asked.
fn inspect_pixel(map: &ShadowMap, [x, y]: [u32; 2], request: &Inspect) -> Result<PixelSummary> {
    let index = request.level;
    let level = level(map, index)?;
    if x >= level.width || y >= level.height {
        let [width, height] = [level.width, level.height];
        let what = if index == 0 { "the map".to_owned() } else { format!("level {index}") };
        bail!("pixel ({x}, {y}) lies outside {what} of {width} × {height} pixels");
    }
    if let Some(file) = &request.plot {
        let pixel = TileRect { x, y, width: 1, height: 1 };
        let name = request.file.file_name().unwrap_or_default().to_string_lossy();
        let of_level = if index == 0 { String::new() } else { format!(" of level {index}") };
        let title = |vertices| format!("{name}, pixel ({x}, {y}){of_level}, {vertices} vertices");
        match functions(map, index, pixel)? {
            AnyDeepMap::Mono(map) => {
                let function = map.pixel(0, 0);
                plot_pixel(function, &title(function.len()), file)
            }
            AnyDeepMap::Rgb(map) => {
                let function = map.pixel(0, 0);
                plot_pixel(function, &title(function.len()), file)
            }
        }?;
    }
    Ok(PixelSummary::new(index, [x, y], map.contents(index, [x, y])?))
}

fn level(map: &ShadowMap, index: u32) -> Result<&Level> {
    let levels = map.levels();
    levels.get(index as usize).with_context(|| {
        format!("there is no level {index}: the map has {}, counted from 0", levels.len())
    })
}

/// Plots a pixel's function.
pub(crate) fn plot_pixel<T: Transmittance>(
    function: VisibilityView<'_, T>,
    title: &str,
    file: &ImageFile,
) -> Result<()> {
    let drawn = match file.format {
        ImageFormat::Svg => plot::svg(function, title)?.into_bytes(),
        _ => plot::png(function, title)?,
    };
    write_file(&file.path, &drawn)
}

/// Draws the transmittance at a depth.
pub(crate) fn write_slice(map: &ShadowMap, file: &SliceFile) -> Result<()> {
    let (rows, channels) = (level(map, 0)?.tile_height, usize::from(map.channels()));
    let slice = Slice::new(map.size(), channels, rows, file.depth, |rect| functions(map, 0, rect));
    let encoded = match file.image.format {
        ImageFormat::Exr => slice.exr(&map.metadata().info)?,
        _ => slice.png()?,
    };
    write_file(&file.image.path, &encoded)
}

fn write_file(path: &Path, bytes: &[u8]) -> Result<()> {
    Ok(replace_file(path, bytes)?)
}
