//! `inspect`: what a map says of itself, and what is in it.

use std::io::{self, BufWriter, StdoutLock, Write};
use std::path::Path;

use anyhow::{Context, Result, bail};
use deepshadow::ShadowMap;
use deepshadow::files::detail::AnyDeepMap;
use deepshadow::files::detail::{Level, TileRect, replace_file};
use deepshadow::visibility::Transmittance;
use deepshadow::visibility::detail::VisibilityView;
use serde::Serialize;

use crate::args::{ImageFile, ImageFormat, Inspect, SliceFile};
use crate::input::{Input, STREAM};
use crate::openable::{Openable, is_openexr};
use crate::output::image_summary::ImageSummary;
use crate::output::slice::Slice;
use crate::output::summary::{PixelSummary, Summary};
use crate::output::{plot, printable};
use crate::page::Page;

pub(crate) fn run(request: &Inspect) -> Result<()> {
    let input = Input::new(&request.file)?;
    if is_openexr(input.path()) {
        return run_image(&input, request);
    }
    let map = ShadowMap::open(input.path())?;
    let mut summary = Summary::new(&map)?;
    if let Some(pixel) = request.pixel {
        summary.pixel = Some(inspect_pixel(&map, pixel, input.name(), request)?);
    }
    draw(&map, input.name(), request)?;
    print(request, &summary, |output| summary.write_text(output))
}

/// Shows an image: what it has itself, and pictures of the map that is made of it.
fn run_image(input: &Input, request: &Inspect) -> Result<()> {
    let summary = ImageSummary::new(input.path(), request.pixel)?;
    if request.plot.is_some() || request.slice.is_some() || request.html.is_some() {
        let made = Openable::open(input.path())?;
        if let Some(pixel) = request.pixel {
            inspect_pixel(made.map(), pixel, input.name(), request)?;
        }
        draw(made.map(), input.name(), request)?;
    }
    print(request, &summary, |output| summary.write_text(output))
}

/// The slice and the page, if they are asked for.
fn draw(map: &ShadowMap, name: &str, request: &Inspect) -> Result<()> {
    if let Some(file) = &request.slice {
        write_slice(map, file)?;
    }
    if let Some(file) = &request.html {
        let maps = vec![(name.to_owned(), map)];
        Page { maps, difference: None, limit: request.max_size }.write(file)?;
    }
    Ok(())
}

fn print(
    request: &Inspect,
    summary: &impl Serialize,
    text: impl FnOnce(&mut BufWriter<StdoutLock<'static>>) -> io::Result<()>,
) -> Result<()> {
    // The page is what stdout has.
    if request.html.as_deref().is_some_and(|file| file.as_os_str() == STREAM) {
        return Ok(());
    }
    let mut output = BufWriter::new(io::stdout().lock());
    if request.json {
        serde_json::to_writer(&mut output, summary).map_err(io::Error::from)?;
        writeln!(output)?;
    } else {
        writeln!(output, "{}", printable(&request.file.to_string_lossy()))?;
        text(&mut output)?;
    }
    Ok(output.flush()?)
}

/// The visibility functions of some pixels.
fn functions(map: &ShadowMap, level: u32, rect: TileRect) -> Result<AnyDeepMap> {
    let found = map.functions(level, rect)?;
    found.with_context(|| {
        format!(
            "a map of kind {} has no visibility functions to draw, as kinds deep and mtsm have: \
             --pixel lists what it stores, and --html shows it",
            map.kind()
        )
    })
}

/// What is stored of a pixel, and its function plotted if that is asked.
fn inspect_pixel(
    map: &ShadowMap,
    [x, y]: [u32; 2],
    name: &str,
    request: &Inspect,
) -> Result<PixelSummary> {
    let index = request.level;
    let level = level(map, index)?;
    if x >= level.width || y >= level.height {
        let [width, height] = [level.width, level.height];
        let what = if index == 0 { "the map".to_owned() } else { format!("level {index}") };
        let [right, bottom] = [width, height].map(|side| side - 1);
        bail!(
            "pixel ({x}, {y}) lies outside {what} of {width} × {height} pixels: columns are 0 to \
             {right}, rows 0 to {bottom}"
        );
    }
    if let Some(file) = &request.plot {
        let pixel = TileRect { x, y, width: 1, height: 1 };
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
    let encoded = match file.image.format {
        ImageFormat::Exr => slice_of(map, file.depth, |slice| slice.exr(&map.metadata().info)),
        _ => slice_of(map, file.depth, |slice| slice.png()),
    };
    write_file(&file.image.path, &encoded?)
}

/// What `make` makes of the slice through a map at a depth.
pub(super) fn slice_of<V>(
    map: &ShadowMap,
    depth: f32,
    make: impl FnOnce(&Slice<&dyn Fn(TileRect) -> Result<AnyDeepMap>>) -> Result<V>,
) -> Result<V> {
    let (rows, channels) = (level(map, 0)?.tile_height, map.channels());
    make(&Slice::new(map.size(), channels, rows, depth, &|rect| functions(map, 0, rect)))
}

fn write_file(path: &Path, bytes: &[u8]) -> Result<()> {
    Ok(replace_file(path, bytes)?)
}
