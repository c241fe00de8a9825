//! Figure 9: lookup time against filter width.

use anyhow::Result;
use dsm_core::detail::Pyramid;
use dsm_core::{
    DeepMap, Filter, FilterShape, Footprint, LevelChoice, PixelSampling, Receiver, filtered_lookup,
};
use shadow_maps::detail::Blocking;
use shadow_maps::plain::{DepthMap, DepthMapSettings, PercentageCloserFilter};
use std::sync::Arc;

use super::machine::machine;
use super::plot::{Panel, svg};
use super::report::table;
use super::timing::{Pass, interleaved, pass};
use super::{Bakes, Report, Stage};

/// Taps of percentage closer filtering, as in the paper.
const TAPS: u32 = 64;

/// One filter width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure9Row {
    /// The filter's full width in pixels of the deep map.
    pub width: f64,
    /// Nanoseconds a lookup takes in the deep map with mip levels, in the
    /// finest level alone, and by percentage closer filtering.
    pub nanoseconds: [f64; 3],
}

/// Figure 9, measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure9 {
    /// By width, ascending; each twice the one before.
    pub rows: Vec<Figure9Row>,
    /// The same for widths between those, where two levels are read.
    pub between: Vec<Figure9Row>,
    map: u32,
    parameters: String,
}

impl Figure9 {
    /// Measures it.
    ///
    /// # Errors
    ///
    /// What the code under test says.
    pub fn measure(stage: &Stage, bakes: &mut Bakes) -> Result<Self> {
        let effort = &stage.effort;
        let side = effort.sides.iter().copied().filter(|&side| side <= 16).max().unwrap_or(2);
        let samples = side * side;
        let mut settings = DepthMapSettings::new([effort.map; 2], samples)?;
        settings.sampling = PixelSampling::new(samples, 0)?;
        settings.blocking = Blocking::Opaque;
        let depths = Arc::new(DepthMap::sample(&stage.source, &settings)?);
        let pyramid = Pyramid::new(bakes.map(stage, side)?.read_levels()?)?;
        let widths =
            || (1..).map(|power| 2.0_f32.powi(power)).take_while(|&w| w < effort.map as f32);
        let all: Vec<f32> = widths().chain(widths().map(|width| 1.5 * width)).collect();
        let times = lookup_times(stage, &depths, &pyramid, &all)?;
        let mut rows = all
            .iter()
            .zip(times)
            .map(|(&width, nanoseconds)| Figure9Row { width: width.into(), nanoseconds });
        let (rows, between) = (rows.by_ref().take(widths().count()).collect(), rows.collect());
        let parameters = format!(
            "Scene `hairball` with opaque hairs, deep map of {0} × {0} pixels with {1} samples \
             each, normal map of {2} × {2} depths, {3} taps. {4} receivers seen by the scene's \
             camera in scanline order, box filter. One thread; medians of {5} rounds, methods \
             interleaved. {6}.",
            effort.map,
            samples,
            effort.map * side,
            TAPS,
            stage.receivers.len(),
            effort.rounds,
            machine(),
        );
        Ok(Self { rows, between, map: effort.map, parameters })
    }

    /// How many times longer the slowest width takes than the fastest, with mip
    /// levels.
    #[must_use]
    pub fn variation_with_mips(&self) -> f64 {
        variation(&self.rows, 0)
    }

    /// How many times longer the widest filter takes than the narrowest
    /// without mip levels.
    #[must_use]
    pub fn growth_without_mips(&self) -> f64 {
        match (self.rows.first(), self.rows.last()) {
            (Some(first), Some(last)) => last.nanoseconds[1] / first.nanoseconds[1],
            _ => f64::NAN,
        }
    }

    /// The page and the plot.
    ///
    /// # Errors
    ///
    /// If the plot can't be drawn.
    pub fn report(&self) -> Result<Report> {
        let share = |row: &Figure9Row| row.width / f64::from(self.map);
        let rows = |rows: &[Figure9Row]| {
            let rows = rows.iter().map(|row| {
                let [mips, without, pcf] = row.nanoseconds.map(|time| format!("{time:.0}"));
                vec![format!("{}", row.width), format!("{:.4}", share(row)), mips, without, pcf]
            });
            let header =
                ["pixels", "of the map", "deep, mips: ns", "deep, finest level: ns", "PCF: ns"];
            table(&header, rows)
        };
        let page = format!(
            include_str!("figure9.md"),
            rows = rows(&self.rows),
            between = rows(&self.between),
            variation = self.variation_with_mips(),
            between_variation = variation(&self.between, 0),
            between_ratio = mean(&self.between) / mean(&self.rows),
            growth = self.growth_without_mips(),
            pcf = variation(&self.rows, 2),
            parameters = self.parameters,
        );
        let curve = |method: usize| {
            self.rows.iter().map(|row| (share(row), row.nanoseconds[method])).collect()
        };
        let panel = Panel {
            title: "Time of a lookup",
            x: "filter width, of the map's",
            y: "ns",
            curves: vec![
                ("PCF, 8 × 8 taps", curve(2)),
                ("deep, mip levels", curve(0)),
                ("deep, finest level", curve(1)),
            ],
        };
        Ok(Report { name: "figure-9", page, plot: svg(&[panel])? })
    }
}

/// Nanoseconds that a lookup takes over filters of these widths: with mip levels,
/// in the finest alone, and by percentage closer filtering. All take turns, the
/// widths of one method next to each other, since they are compared.
fn lookup_times(
    stage: &Stage,
    depths: &Arc<DepthMap>,
    pyramid: &Pyramid<DeepMap<f32>>,
    widths: &[f32],
) -> Result<Vec<[f64; 3]>> {
    let all = &stage.receivers;
    let mut methods: Vec<Box<dyn FnMut() -> Pass + '_>> = Vec::new();
    let footprints = widths
        .iter()
        .map(|&width| Ok(Footprint::Isotropic(Filter::new(FilterShape::Box, width)?)))
        .collect::<Result<Vec<_>>>()?;
    for &footprint in &footprints {
        let mut next = 0;
        let light = move |at: Receiver| {
            let Ok(light) = pyramid.lookup(&at, &footprint, LevelChoice::Auto);
            light
        };
        methods.push(Box::new(move || pass(all, &mut next, 4096, |_, at| light(at))));
    }
    for (&footprint, width) in footprints.iter().zip(widths) {
        let mut next = 0;
        let few = (65536.0 / (width * width)).clamp(8.0, 4096.0) as usize;
        let light = move |at: Receiver| {
            let Ok(light) = filtered_lookup(&pyramid.levels()[0], &at, &footprint);
            light
        };
        methods.push(Box::new(move || pass(all, &mut next, few, |_, at| light(at))));
    }
    for &width in widths {
        let mut next = 0;
        let pcf = PercentageCloserFilter::new(Arc::clone(depths), TAPS)?.with_width(width)?;
        methods.push(Box::new(move || {
            pass(all, &mut next, 2048, |index, at| pcf.lookup(&at, index as u64))
        }));
    }
    let times = interleaved(stage.effort.rounds, stage.effort.seconds, methods);
    let of = |index: usize| [0, 1, 2].map(|method| times[method * widths.len() + index]);
    Ok((0..widths.len()).map(of).collect())
}

fn variation(rows: &[Figure9Row], method: usize) -> f64 {
    let times = || rows.iter().map(|row| row.nanoseconds[method]);
    times().fold(0.0, f64::max) / times().fold(f64::INFINITY, f64::min)
}

/// The mean time with mip levels.
fn mean(rows: &[Figure9Row]) -> f64 {
    rows.iter().map(|row| row.nanoseconds[0]).sum::<f64>() / rows.len() as f64
}
