//! Figure 8: how deep maps grow with the number of samples.

use anyhow::Result;
use dsm_core::DeepMap;

use super::machine::machine;
use super::plot::{Panel, svg};
use super::report::table;
use super::{Bakes, Report, Stage};

/// The growth that the paper predicts for functions that become smooth (§4).
const PREDICTED: f64 = 0.25;

/// One number of samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure8Row {
    /// Samples along the side of a pixel; N is its square.
    pub side: u32,
    /// Vertices a pixel of the map.
    pub vertices: f64,
    /// Vertices a pixel that sees hair.
    pub hair_vertices: f64,
}

/// Figure 8, measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure8 {
    /// By number of samples, ascending.
    pub rows: Vec<Figure8Row>,
    /// The slope of log vertices over log N: of all pixels, and of those that
    /// see hair.
    pub slopes: [f64; 2],
    /// The share of pixels that see hair.
    pub hair_share: f64,
    parameters: String,
}

impl Figure8 {
    /// Measures it.
    ///
    /// # Errors
    ///
    /// What the code under test says.
    pub fn measure(stage: &Stage, bakes: &mut Bakes) -> Result<Self> {
        let is_hair = pixels_with_hair(stage)?;
        let hairs = is_hair.iter().filter(|&&is_hair| is_hair).count();
        let mut rows = Vec::new();
        for &side in &stage.effort.sides {
            let map = bakes.map(stage, side)?.read()?;
            let [vertices, hair_vertices] = [false, true].map(|only_hair| {
                let counted = |&(index, _): &(usize, usize)| !only_hair || is_hair[index];
                let counts = || vertex_counts(&map).enumerate().filter(counted);
                counts().map(|(_, count)| count).sum::<usize>() as f64 / counts().count() as f64
            });
            rows.push(Figure8Row { side, vertices, hair_vertices });
        }
        let slope = |value: fn(&Figure8Row) -> f64| {
            log_log_slope(rows.iter().map(|row| (f64::from(row.side).powi(2), value(row))))
        };
        let slopes = [slope(|row| row.vertices), slope(|row| row.hair_vertices)];
        let parameters = format!(
            "Scene `hairball` with opaque hairs, maps of {0} × {0} pixels, tolerance 0.25/√N. {1}.",
            stage.effort.map,
            machine()
        );
        let hair_share = hairs as f64 / is_hair.len() as f64;
        Ok(Self { rows, slopes, hair_share, parameters })
    }

    /// The page and the plot.
    ///
    /// # Errors
    ///
    /// If the plot can't be drawn.
    pub fn report(&self) -> Result<Report> {
        let rows = self.rows.iter().map(|row| {
            vec![
                format!("{0} × {0}", row.side),
                format!("{:.2}", row.vertices),
                format!("{:.2}", row.hair_vertices),
            ]
        });
        let page = format!(
            include_str!("figure8.md"),
            rows = table(&["samples", "vertices a pixel", "a pixel with hair"], rows),
            all = self.slopes[0],
            hair = self.slopes[1],
            share = self.hair_share * 100.0,
            parameters = self.parameters,
        );
        let curve = |value: &dyn Fn(&Figure8Row) -> f64| {
            let point = |row: &Figure8Row| (f64::from(row.side).powi(2), value(row));
            self.rows.iter().map(point).collect::<Vec<_>>()
        };
        let first = self.rows.first().copied();
        let predicted = |row: &Figure8Row| {
            first.map_or(f64::NAN, |first| {
                let growth = f64::from(row.side) / f64::from(first.side);
                first.hair_vertices * growth.powf(2.0 * PREDICTED)
            })
        };
        let panel = Panel {
            title: "Growth of deep shadow maps",
            x: "samples a pixel, N",
            y: "vertices a pixel",
            curves: vec![
                ("all pixels", curve(&|row| row.vertices)),
                ("pixels with hair", curve(&|row| row.hair_vertices)),
                ("N^¼", curve(&predicted)),
            ],
        };
        Ok(Report { name: "figure-8", page, plot: svg(&[panel])? })
    }
}

/// The vertices of every pixel, row by row.
fn vertex_counts(map: &DeepMap<f32>) -> impl Iterator<Item = usize> + '_ {
    let view = map.pixels().view();
    let rows = 0..view.height();
    rows.flat_map(move |y| (0..view.width()).map(move |x| view.pixel(x, y).depths().len()))
}

/// Whether each pixel of the map sees hair: meets more without a floor and a
/// ball than nothing.
fn pixels_with_hair(stage: &Stage) -> Result<Vec<bool>> {
    use dsm_core::{BakeSettings, Baker};
    use dsm_scene::{SceneRasterizer, Shape};

    let mut hair = stage.scene.clone();
    hair.objects.retain(|object| matches!(&*object.shape, Shape::Curves(_)));
    let source = SceneRasterizer::<f32>::new(&hair, stage.raster)?;
    let map = Baker::new(source, BakeSettings::new([stage.effort.map; 2])?)?.map()?;
    Ok(vertex_counts(&map).map(|count| count > 0).collect())
}

/// The slope of the line through the logarithms of `points` that is nearest to
/// them by least squares.
#[must_use]
pub fn log_log_slope(points: impl IntoIterator<Item = (f64, f64)>) -> f64 {
    let points: Vec<(f64, f64)> =
        points.into_iter().map(|(x, y)| (f64::ln(x), f64::ln(y))).collect();
    let count = points.len() as f64;
    let mean = |value: fn(&(f64, f64)) -> f64| points.iter().map(value).sum::<f64>() / count;
    let (x, y) = (mean(|point| point.0), mean(|point| point.1));
    let products: f64 = points.iter().map(|point| (point.0 - x) * (point.1 - y)).sum();
    let squares: f64 = points.iter().map(|point| (point.0 - x) * (point.0 - x)).sum();
    products / squares
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_are_slopes() {
        let points = [1.0_f64, 4.0, 9.0, 100.0].map(|x| (x, 3.0 * x.powf(0.25)));
        assert!((log_log_slope(points) - 0.25).abs() < 1e-12);
        assert!((log_log_slope([(1.0, 1.0), (10.0, 2.0), (100.0, 1.0)])).abs() < 1e-12);
    }
}
