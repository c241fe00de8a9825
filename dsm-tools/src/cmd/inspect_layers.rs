//! `inspect` of layered maps.

use anyhow::{Result, bail};
use dsm_core::{Rgb, Transmittance};
use dsm_trace::MinMaxPyramid;
use mtsm::{LayeredKind, LayeredReader};

use super::inspect::{plot_pixel, write_slice};
use crate::args::Inspect;
use crate::output::layers::{LayersOfPixel, LayersSummary};
use crate::output::summary::Summary;

/// What a layered map says of itself, and what is asked of its pixels.
pub(crate) fn summary<'a>(reader: &'a LayeredReader, request: &Inspect) -> Result<Summary<'a>> {
    let mut summary = Summary::new(reader.kind().name(), reader.metadata(), reader.container())?;
    if reader.metadata().channels == 1 {
        inspect::<f32>(reader, request, &mut summary)
    } else {
        inspect::<Rgb>(reader, request, &mut summary)
    }?;
    Ok(summary)
}

fn inspect<T: Transmittance>(
    reader: &LayeredReader,
    request: &Inspect,
    summary: &mut Summary<'_>,
) -> Result<()> {
    let size = [reader.metadata().width, reader.metadata().height];
    let pyramid = match reader.kind() {
        LayeredKind::Mtsm => {
            let map = reader.multilayer_map::<T>()?;
            if let Some(file) = &request.slice {
                write_slice(&map.deep_map()?, file)?;
            }
            MinMaxPyramid::of_depths(size, 0.0, |pixel| map.pixels().depth_range(pixel))
        }
        LayeredKind::Fragments => reader.fragment_map::<T>()?.pyramid(),
        _ => {
            let map = reader.multilayer_depth_map::<T>()?;
            MinMaxPyramid::of_depths(size, 0.0, |pixel| map.pixels().depth_range(pixel))
        }
    }?;
    summary.layers = Some(LayersSummary::new(reader.layering(), reader.summary()?, &pyramid));
    if reader.kind() != LayeredKind::Mtsm && (request.slice.is_some() || request.plot.is_some()) {
        bail!("a map of kind {} has no visibility functions to draw", reader.kind().name());
    }
    if let Some(pixel) = request.pixel {
        if request.level > 0 {
            bail!("there is no level {}: a layered map has one level, 0", request.level);
        }
        if let Some(file) = &request.plot {
            let [x, y] = pixel;
            let map = reader.multilayer_map::<T>()?;
            let deep = map.deep_map()?;
            if x >= size[0] || y >= size[1] {
                bail!("pixel ({x}, {y}) lies outside the map of {} × {} pixels", size[0], size[1]);
            }
            let name = request.file.file_name().unwrap_or_default().to_string_lossy();
            plot_pixel(deep.pixel(x, y), &format!("{name}, pixel ({x}, {y}), first run"), file)?;
        }
        let runs = reader.pixel_runs::<T>(pixel)?;
        summary.layers_of_pixel = Some(LayersOfPixel::new(pixel, reader.kind(), &runs));
    }
    Ok(())
}
