//! `inspect`: what a map says of itself, and what is in it.

use std::io::{self, BufWriter, Write};
use std::path::Path;

use anyhow::{Result, bail};
use dsm_core::{DeepMap, Rgb, Transmittance, VisibilityFunction, VisibilityView};
use dsm_io::{AnyDeepMap, Container, Limits, MapReader, TileId};
use mtsm::{LayeredKind, LayeredReader};

use super::inspect_layers;
use crate::args::{ImageFile, ImageFormat, Inspect, SliceFile};
use crate::output::plot;
use crate::output::slice::Slice;
use crate::output::summary::{PixelSummary, Summary};

pub(crate) fn run(request: &Inspect) -> Result<()> {
    let limits = Limits::default();
    let container = Container::open(&request.file, &limits)?;
    if LayeredKind::from_name(&container.kind()?).is_some() {
        let reader = LayeredReader::new(container, &limits)?;
        return print(&inspect_layers::summary(&reader, request)?, request);
    }
    let reader = MapReader::new(container, &limits)?;
    let mut summary = Summary::new("deep", reader.metadata(), reader.container())?;
    if let Some(pixel) = request.pixel {
        summary.pixel = Some(if reader.metadata().channels == 1 {
            inspect_pixel::<f32>(&reader, pixel, request)
        } else {
            inspect_pixel::<Rgb>(&reader, pixel, request)
        }?);
    }
    if let Some(file) = &request.slice {
        match &AnyDeepMap::read(&reader, 0)? {
            AnyDeepMap::Mono(map) => write_slice(map, file),
            AnyDeepMap::Rgb(map) => write_slice(map, file),
        }?;
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

/// The vertices of a pixel, plotted if that is asked.
fn inspect_pixel<T: Transmittance>(
    reader: &MapReader,
    [x, y]: [u32; 2],
    request: &Inspect,
) -> Result<PixelSummary> {
    let level = request.level;
    let function = read_pixel::<T>(reader, level, [x, y])?;
    if let Some(file) = &request.plot {
        let name = request.file.file_name().unwrap_or_default().to_string_lossy();
        let vertices = function.view().len();
        let of_level = if level == 0 { String::new() } else { format!(" of level {level}") };
        let title = format!("{name}, pixel ({x}, {y}){of_level}, {vertices} vertices");
        plot_pixel(function.view(), &title, file)?;
    }
    Ok(PixelSummary::new(level, [x, y], function.view()))
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

fn read_pixel<T: Transmittance>(
    reader: &MapReader,
    index: u32,
    [x, y]: [u32; 2],
) -> Result<VisibilityFunction<T>> {
    let count = reader.levels().len();
    let Some(level) = reader.levels().get(index as usize) else {
        bail!("there is no level {index}: the map has {count}, counted from 0");
    };
    if x >= level.width || y >= level.height {
        let [width, height] = [level.width, level.height];
        let what = if index == 0 { "the map".to_owned() } else { format!("level {index}") };
        bail!("pixel ({x}, {y}) lies outside {what} of {width} × {height} pixels");
    }
    let id = TileId::new(index, x / level.tile_width, y / level.tile_height);
    let (tile, rect) = (reader.tile::<T>(id)?, reader.tile_rect(id)?);
    Ok(tile.view().pixel(x - rect.x, y - rect.y).to_function())
}

/// Draws the light that is left at a depth.
pub(crate) fn write_slice<T: Transmittance>(map: &DeepMap<T>, file: &SliceFile) -> Result<()> {
    let slice = Slice::new(map, file.depth)?;
    let encoded = match file.image.format {
        ImageFormat::Exr => slice.exr(map.info())?,
        _ => slice.png()?,
    };
    write_file(&file.image.path, &encoded)
}

fn write_file(path: &Path, bytes: &[u8]) -> Result<()> {
    Ok(dsm_io::replace_file(path, bytes)?)
}
