//! Plots with logarithmic axes, as SVG.

use anyhow::{Result, anyhow};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::register_font;

/// Width and height of a panel, in pixels of an SVG.
const PANEL: (u32, u32) = (560, 440);
/// Units a pixel: the library rounds corners to whole units.
const UNITS: u32 = 8;
const FAMILY: &str = "sans-serif";
/// Measures the labels.
const FONT: &[u8] = epaint_default_fonts::UBUNTU_LIGHT;
const INK: RGBColor = RGBColor(0x2b, 0x2f, 0x36);
const GRID: RGBColor = RGBColor(0xdf, 0xe2, 0xe7);
const COLOURS: [RGBColor; 5] = [
    RGBColor(0xc4, 0x4e, 0x2c),
    RGBColor(0x1f, 0x5f, 0xa8),
    RGBColor(0x2c, 0x96, 0x4b),
    RGBColor(0x80, 0x86, 0x90),
    RGBColor(0x7a, 0x4f, 0xa3),
];

/// Some curves over the same axes.
pub(crate) struct Panel {
    pub(crate) title: &'static str,
    pub(crate) x: &'static str,
    pub(crate) y: &'static str,
    /// Each a name and its points, all above 0.
    pub(crate) curves: Vec<(&'static str, Vec<(f64, f64)>)>,
}

/// The panels side by side.
///
/// # Errors
///
/// If a panel has no points.
pub(crate) fn svg(panels: &[Panel]) -> Result<String> {
    let size = (PANEL.0 * panels.len() as u32, PANEL.1);
    let units = (size.0 * UNITS, size.1 * UNITS);
    let mut document = String::new();
    {
        let area = SVGBackend::with_string(&mut document, units).into_drawing_area();
        let all = area.split_evenly((1, panels.len()));
        area.fill(&WHITE).map_err(|error| anyhow!("drawing a plot: {error}"))?;
        for (area, panel) in all.iter().zip(panels) {
            draw(area, panel).map_err(|error| anyhow!("drawing a plot: {error}"))?;
        }
    }
    // The view box stays: it makes the units small.
    let written =
        |scale: u32| format!("width=\"{}\" height=\"{}\"", size.0 * scale, size.1 * scale);
    Ok(document.replacen(&written(UNITS), &written(1), 1))
}

fn draw(
    area: &DrawingArea<SVGBackend<'_>, Shift>,
    panel: &Panel,
) -> std::result::Result<(), Box<dyn std::error::Error>> {
    register_font(FAMILY, FontStyle::Normal, FONT).map_err(|_| "the built-in font is no font")?;
    let text = |size: u32| (FAMILY, size * UNITS).into_font().color(&INK);
    let points = || panel.curves.iter().flat_map(|(_, points)| points.iter().copied());
    if points().next().is_none() {
        return Err("a panel has no points".into());
    }
    let span = |values: &mut dyn Iterator<Item = f64>| {
        let (low, high) =
            values.fold((f64::INFINITY, 0.0_f64), |(low, high), v| (low.min(v), high.max(v)));
        (low * 0.8, high * 1.25)
    };
    let (left, right) = span(&mut points().map(|point| point.0));
    let (bottom, top) = span(&mut points().map(|point| point.1));
    let mut chart = ChartBuilder::on(area)
        .caption(panel.title, text(18))
        .margin(16 * UNITS)
        .x_label_area_size(46 * UNITS)
        .y_label_area_size(66 * UNITS)
        .build_cartesian_2d((left..right).log_scale(), (bottom..top).log_scale())?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID.stroke_width(UNITS))
        .axis_style(INK.stroke_width(UNITS))
        .set_all_tick_mark_size(5 * UNITS)
        .label_style(text(13))
        .axis_desc_style(text(15))
        .x_desc(panel.x)
        .y_desc(panel.y)
        .x_label_formatter(&|value| label(*value))
        .y_label_formatter(&|value| label(*value))
        .draw()?;
    for ((name, points), colour) in panel.curves.iter().zip(COLOURS.iter().cycle()) {
        let line = colour.stroke_width(2 * UNITS);
        chart
            .draw_series(LineSeries::new(points.iter().copied(), line))?
            .label(*name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 22 * UNITS as i32, y)], line));
        let dots = points.iter().map(|&at| Circle::new(at, 4 * UNITS, colour.filled()));
        chart.draw_series(dots)?;
    }
    chart
        .configure_series_labels()
        .label_font(text(13))
        .legend_area_size(28 * UNITS)
        .margin(8 * UNITS)
        .background_style(WHITE.mix(0.8))
        .position(SeriesLabelPosition::UpperLeft)
        .draw()?;
    area.present()?;
    Ok(())
}

/// A number on an axis, short.
fn label(value: f64) -> String {
    if (0.01..1e5).contains(&value) {
        let decimals = (1.0 - value.log10().floor()).clamp(0.0, 3.0) as usize;
        let text = format!("{value:.decimals$}");
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text
        }
    } else {
        format!("{value:.0e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let values = [0.05, 0.5, 1.0, 2.5, 64.0, 1500.0, 2e7];
        assert_eq!(values.map(label), ["0.05", "0.5", "1", "2.5", "64", "1500", "2e7"]);
    }

    #[test]
    fn every_curve_is_drawn() {
        let curves = vec![("a", vec![(1.0, 2.0), (4.0, 8.0)]), ("b", vec![(2.0, 2.0)])];
        let panel = Panel { title: "t", x: "x", y: "y", curves };
        let document = svg(&[panel]).unwrap();
        assert_eq!(document.matches("<circle").count(), 3);
        assert!(document.starts_with("<svg width=\"560\" height=\"440\""));
        let nothing = Panel { title: "t", x: "x", y: "y", curves: Vec::new() };
        assert!(svg(&[nothing]).is_err());
    }
}
