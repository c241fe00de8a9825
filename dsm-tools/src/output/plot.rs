//! A plot of one pixel's visibility function, as SVG or PNG.

use anyhow::{Context, Result, anyhow};
use deepshadow::visibility::Transmittance;
use deepshadow::visibility::detail::VisibilityView;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::register_font;

use super::printable;

/// Width and height of a plot, in pixels of an SVG.
const SIZE: (u32, u32) = (900, 560);
/// Units in which a plot is drawn a pixel of the SVG. The library rounds
/// corners to whole units, which would make ramps wavy if they were pixels.
const UNITS: u32 = 8;
/// PNG pixels a pixel of the SVG, and the side of the square of units that each
/// of them averages: the bitmaps of the library have no smooth edges.
const PNG_SCALE: u32 = 2;
const SMOOTHING: u32 = UNITS / PNG_SCALE;
/// The family that [`FONT`] has, and that SVG viewers look for.
const FAMILY: &str = "sans-serif";
/// A fresh machine has no fonts, so the program brings its own.
const FONT: &[u8] = epaint_default_fonts::UBUNTU_LIGHT;

const INK: RGBColor = RGBColor(0x2b, 0x2f, 0x36);
const GRID: RGBColor = RGBColor(0xdf, 0xe2, 0xe7);
/// The curve of a mono pixel.
const MONO: (&str, RGBColor) = ("V", RGBColor(0x1f, 0x5f, 0xa8));
/// The curves of a coloured pixel.
const CHANNELS: [(&str, RGBColor); 3] = [
    ("red", RGBColor(0xd0, 0x3a, 0x3a)),
    ("green", RGBColor(0x2c, 0x96, 0x4b)),
    ("blue", RGBColor(0x2f, 0x62, 0xc9)),
];

/// The plot of `function` as an SVG document.
///
/// Steps are vertical, ramps are straight, and the curve runs from edge to
/// edge: 1 before the first vertex, the last value after the last.
pub(crate) fn svg<T: Transmittance>(
    function: VisibilityView<'_, T>,
    title: &str,
) -> Result<String> {
    let mut document = String::new();
    {
        let units = (SIZE.0 * UNITS, SIZE.1 * UNITS);
        let area = SVGBackend::with_string(&mut document, units).into_drawing_area();
        draw(&area, function, title).map_err(|error| anyhow!("drawing the plot: {error}"))?;
    }
    // The view box stays: it makes the units small.
    let size = |scale| format!("width=\"{}\" height=\"{}\"", SIZE.0 * scale, SIZE.1 * scale);
    Ok(document.replacen(&size(UNITS), &size(1), 1))
}

/// The plot of `function` as a PNG file.
pub(crate) fn png<T: Transmittance>(
    function: VisibilityView<'_, T>,
    title: &str,
) -> Result<Vec<u8>> {
    let [width, height] = [SIZE.0, SIZE.1].map(|side| side * UNITS);
    let mut fine = vec![0; width as usize * height as usize * 3];
    {
        let area = BitMapBackend::with_buffer(&mut fine, (width, height)).into_drawing_area();
        draw(&area, function, title).map_err(|error| anyhow!("drawing the plot: {error}"))?;
    }
    let mut file = Vec::new();
    let size = [SIZE.0, SIZE.1].map(|side| side * PNG_SCALE);
    let mut encoder = png::Encoder::new(&mut file, size[0], size[1]);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().context("encoding the plot")?;
    writer.write_image_data(&averages(&fine, width)).context("encoding the plot")?;
    writer.finish().context("encoding the plot")?;
    Ok(file)
}

/// The means of squares of [`SMOOTHING`] pixels of an RGB image `width` wide.
fn averages(fine: &[u8], width: u32) -> Vec<u8> {
    let (row, side) = (width as usize * 3, SMOOTHING as usize);
    let mut means = Vec::with_capacity(fine.len() / (side * side));
    for rows in fine.chunks_exact(row * side) {
        for x in (0..row).step_by(3 * side) {
            for channel in x..x + 3 {
                let square = rows
                    .chunks_exact(row)
                    .flat_map(|row| row[channel..].iter().step_by(3).take(side));
                let sum: u32 = square.map(|&value| u32::from(value)).sum();
                means.push((sum / (SMOOTHING * SMOOTHING)) as u8);
            }
        }
    }
    means
}

type Drawn = std::result::Result<(), Box<dyn std::error::Error>>;

fn draw<B: DrawingBackend<ErrorType: 'static>, T: Transmittance>(
    area: &DrawingArea<B, Shift>,
    function: VisibilityView<'_, T>,
    title: &str,
) -> Drawn {
    register_font(FAMILY, FontStyle::Normal, FONT).map_err(|_| "the built-in font is no font")?;
    // Control characters are no XML.
    let title = printable(title);
    let text = |size: u32| (FAMILY, size * UNITS).into_font().color(&INK);
    area.fill(&WHITE)?;
    let (near, far) = padded_range(function.depths());
    let mut chart = ChartBuilder::on(area)
        .caption(&title, text(22))
        .margin(20 * UNITS)
        .x_label_area_size(52 * UNITS)
        .y_label_area_size(64 * UNITS)
        .build_cartesian_2d(near..far, -0.02..1.04)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID.stroke_width(UNITS))
        .axis_style(INK.stroke_width(UNITS))
        .set_all_tick_mark_size(5 * UNITS)
        .label_style(text(16))
        .axis_desc_style(text(18))
        .x_desc("depth z")
        .y_desc("visibility V(z)")
        .x_labels(9)
        .y_labels(11)
        .x_label_formatter(&|depth| depth_label(*depth, far - near))
        .y_label_formatter(&|value| format!("{value:.1}"))
        .draw()?;
    let curves = if function.is_mono() { &[MONO][..] } else { &CHANNELS };
    for (channel, &(name, colour)) in curves.iter().enumerate() {
        let line = colour.stroke_width(3 * UNITS);
        let outline = outline(function, channel, near, far);
        chart
            .draw_series(LineSeries::new(outline, line))?
            .label(name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 24 * UNITS as i32, y)], line));
    }
    if curves.len() > 1 {
        chart
            .configure_series_labels()
            .label_font(text(16))
            .legend_area_size(30 * UNITS)
            .margin(10 * UNITS)
            .background_style(WHITE)
            .position(SeriesLabelPosition::LowerLeft)
            .draw()?;
    }
    area.present()?;
    Ok(())
}

/// The corners of one channel's curve over [`near`, `far`].
fn outline<T: Transmittance>(
    function: VisibilityView<'_, T>,
    channel: usize,
    near: f64,
    far: f64,
) -> Vec<(f64, f64)> {
    let value = |value: T| f64::from(value.channel(channel));
    let vertices = function.vertices().map(|vertex| (f64::from(vertex.z), value(vertex.value)));
    let (first, last) = ((near, 1.0), (far, value(function.last())));
    std::iter::once(first).chain(vertices).chain([last]).collect()
}

/// Where the plot begins and ends: a twelfth more than the vertices on both
/// sides.
fn padded_range(depths: &[f32]) -> (f64, f64) {
    let (Some(&first), Some(&last)) = (depths.first(), depths.last()) else {
        return (0.0, 1.0);
    };
    let (first, last) = (f64::from(first), f64::from(last));
    let extent = if last > first { last - first } else { last.max(1e-6) };
    (first - extent / 12.0, last + extent / 12.0)
}

/// A depth on the axis, with the digits that tell the labels of an axis of
/// this `extent` apart.
fn depth_label(depth: f64, extent: f64) -> String {
    let decimals = (1.5 - extent.log10()).ceil();
    if (-6.0..=6.0).contains(&decimals) {
        format!("{depth:.*}", decimals.max(0.0) as usize)
    } else {
        format!("{depth:.3e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use deepshadow::visibility::{Rgb, Vertex, VisibilityFunction};

    #[test]
    fn the_curve_runs_from_edge_to_edge() {
        let vertices = [(1.0, 1.0), (1.0, 0.5), (2.0, 0.25)];
        let function =
            VisibilityFunction::new(vertices.map(|(z, value)| Vertex::new(z, value))).unwrap();
        let corners = outline::<f32>(function.view(), 0, 0.5, 3.0);
        assert_eq!(corners, [(0.5, 1.0), (1.0, 1.0), (1.0, 0.5), (2.0, 0.25), (3.0, 0.25)]);
    }

    #[test]
    fn the_axis_is_wider_than_the_vertices() {
        for depths in [&[][..], &[0.0], &[0.0, 0.0], &[7.0], &[1.0, 13.0], &[100.0, 100.000_01]] {
            let (near, far) = padded_range(depths);
            assert!(near < far, "{depths:?}");
            assert!(depths.iter().all(|&z| near < f64::from(z) && f64::from(z) < far));
        }
        assert_eq!(padded_range(&[1.0, 13.0]), (0.0, 14.0));
    }

    #[test]
    fn labels_tell_depths_apart() {
        assert_eq!(depth_label(2.5, 3.2), "2.5");
        assert_eq!(depth_label(46.95, 0.3), "46.950");
        assert_eq!(depth_label(1500.0, 4000.0), "1500");
        assert_eq!(depth_label(2e30, 1e31), "2.000e30");
    }

    #[test]
    fn a_mono_plot_has_one_curve_and_a_coloured_one_three() {
        let curves = |svg: &str| svg.matches("stroke-width=\"24\"").count();
        let grey = [Vertex::new(1.0, 1.0), Vertex::new(2.0, 0.5)];
        let grey = VisibilityFunction::new(grey).unwrap();
        assert_eq!(curves(&svg(grey.view(), "a & b").unwrap()), 1);
        let coloured = [Vertex::new(1.0, Rgb::CLEAR), Vertex::new(2.0, Rgb::new(0.5, 0.2, 0.1))];
        let coloured = VisibilityFunction::new(coloured).unwrap();
        // Each has a line in the legend, too.
        assert_eq!(curves(&svg(coloured.view(), "a").unwrap()), 6);
    }

    #[test]
    fn extreme_depths_can_be_drawn() {
        for depths in [[0.0, 0.0], [0.0, f32::MAX], [1e-40, 2e-40], [f32::MAX, f32::MAX]] {
            let vertices = [Vertex::new(depths[0], 1.0), Vertex::new(depths[1], 0.5)];
            let function = VisibilityFunction::<f32>::new(vertices).unwrap();
            let image = png(function.view(), "a <\u{1} b").unwrap();
            assert!(image.starts_with(b"\x89PNG"));
        }
    }
}
