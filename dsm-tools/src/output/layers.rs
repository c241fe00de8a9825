//! What `inspect` says of a layered map's layers.

use std::io::{self, Write};

use dsm_core::Transmittance;
use dsm_trace::MinMaxPyramid;
use mtsm::{Layer, LayeredKind, LayeredSummary, Layering};
use serde::Serialize;

use super::summary::Light;

/// The layers of a whole map.
#[derive(Serialize)]
pub(crate) struct LayersSummary {
    max_layers: u32,
    resets: u32,
    /// The depth of the light's centre.
    light_depth: f32,
    runs: u64,
    most_runs: u64,
    layers: u64,
    most_layers: u64,
    /// What all layers count.
    samples: u64,
    empty_pixels: u64,
    /// From the pixels up.
    pyramid: Vec<PyramidLevel>,
}

/// A level of the pyramid of depths.
#[derive(Serialize)]
struct PyramidLevel {
    width: u32,
    height: u32,
    /// Nodes without a layer.
    empty: u64,
}

impl LayersSummary {
    pub(crate) fn new(layering: Layering, of: LayeredSummary, pyramid: &MinMaxPyramid) -> Self {
        let Layering { max_layers, resets, light_depth } = layering;
        let level = |level| {
            let [width, height] = pyramid.level_size(level);
            let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
            let empty = places.filter(|&(x, y)| pyramid.node(level, x, y).is_none()).count();
            PyramidLevel { width, height, empty: empty as u64 }
        };
        let LayeredSummary { runs, most_runs, layers, most_layers, samples, empty_pixels } = of;
        Self {
            max_layers,
            resets,
            light_depth,
            runs,
            most_runs,
            layers,
            most_layers,
            samples,
            empty_pixels,
            pyramid: (0..pyramid.level_count()).map(level).collect(),
        }
    }

    pub(crate) fn write_text(&self, output: &mut impl Write) -> io::Result<()> {
        let mut line = |name: &str, value: String| writeln!(output, "  {name:<12}{value}");
        line("layers", format!("{}, at most {} of a pixel", self.layers, self.most_layers))?;
        line("runs", format!("{}, at most {} of a pixel", self.runs, self.most_runs))?;
        line("counts", format!("{} samples", self.samples))?;
        line("empty", format!("{} pixels", self.empty_pixels))?;
        line("limits", format!("{} layers, {} resets", self.max_layers, self.resets))?;
        line("light depth", self.light_depth.to_string())?;
        let levels = self.pyramid.iter().map(|level| {
            let PyramidLevel { width, height, empty } = level;
            format!("{width} × {height} ({empty} empty)")
        });
        line("pyramid", levels.collect::<Vec<_>>().join(", "))
    }
}

/// The layers of one pixel.
#[derive(Serialize)]
pub(crate) struct LayersOfPixel {
    x: u32,
    y: u32,
    /// Depth, what the run leaves behind it, and the count, layer by layer.
    runs: Vec<Vec<(f32, Light, u32)>>,
    #[serde(skip)]
    kind: &'static str,
}

impl LayersOfPixel {
    pub(crate) fn new<T: Transmittance>(
        [x, y]: [u32; 2],
        kind: LayeredKind,
        runs: &[Vec<Layer<T>>],
    ) -> Self {
        let layer = |layer: &Layer<T>| (layer.depth, Light::of(layer.visibility), layer.count);
        let runs = runs.iter().map(|run| run.iter().map(layer).collect()).collect();
        Self { x, y, runs, kind: kind.name() }
    }

    pub(crate) fn write_text(&self, output: &mut impl Write) -> io::Result<()> {
        writeln!(output, "\n  pixel ({}, {}) of kind {}", self.x, self.y, self.kind)?;
        if self.runs.is_empty() {
            return writeln!(output, "    no layers: lit at every depth");
        }
        for (index, run) in self.runs.iter().enumerate() {
            writeln!(output, "    run {index}")?;
            writeln!(output, "    {:>14}  {:>10}  V behind", "depth", "samples")?;
            for (depth, light, count) in run {
                writeln!(output, "    {depth:>14}  {count:>10}  {}", light.text())?;
            }
        }
        Ok(())
    }
}
