//! What tracing costs as maps and lights grow.

use anyhow::{Context, Result};

use super::{Method, Page, Study};
use crate::figures::{Panel, svg, table};

/// Seconds that a map may be expected to take, after the one before it.
const PATIENCE: f64 = 60.0;

/// A map of one size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SizeCost {
    /// The method.
    pub method: Method,
    /// Pixels along a side.
    pub side: u32,
    /// Seconds to make it.
    pub seconds: f64,
    /// Its layers.
    pub layers: usize,
    /// Nanoseconds a ray.
    pub nanoseconds: f64,
    /// The mean difference from ray traced shadows.
    pub error: f64,
}

/// A light of one size.
#[derive(Clone, Debug, PartialEq)]
pub struct RadiusCost {
    /// The light's radius.
    pub radius: f64,
    /// Nanoseconds a ray through the scene.
    pub geometry: f64,
    /// Nanoseconds a ray, or a tap, by method.
    pub nanoseconds: Vec<f64>,
}

/// Costs, measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Cost {
    /// By method, then by size, ascending.
    pub sizes: Vec<SizeCost>,
    /// By radius, ascending.
    pub radii: Vec<RadiusCost>,
    /// Sizes that would have taken too long.
    pub left_out: Vec<(Method, u32)>,
    scene: &'static str,
    parameters: String,
}

impl Cost {
    /// Measures it on the last scene.
    ///
    /// # Errors
    ///
    /// What the code under test says.
    pub fn measure(study: &mut Study) -> Result<Self> {
        let stage = study.stages.len().checked_sub(1).context("there is no scene")?;
        let scene = study.stages[stage].name;
        let effort = study.effort.clone();
        let rays = study.stages[stage].points.len() as f64 * f64::from(effort.rays);
        let each = |seconds: f64| seconds / rays * 1e9;
        let mut radii = Vec::new();
        for &radius in &effort.radii {
            let lit = study.lit(stage, radius)?;
            let shadows = lit.shadows.iter();
            let nanoseconds = shadows.map(|shadow| each(shadow.factors.seconds)).collect();
            radii.push(RadiusCost { radius, geometry: each(lit.reference.seconds), nanoseconds });
        }
        let reference = study.reference(stage, effort.radius)?;
        let (mut sizes, mut left_out): (Vec<SizeCost>, _) = (Vec::new(), Vec::new());
        for (method, sides) in
            [(Method::Paper, &effort.maps), (Method::Fragments, &effort.fragment_maps)]
        {
            for &side in sides {
                let before = sizes.last().filter(|cost| cost.method == method);
                let growth = |cost: &SizeCost| f64::from(side / cost.side).powi(2);
                if before.is_some_and(|cost| cost.seconds * growth(cost) > PATIENCE) {
                    left_out.push((method, side));
                    continue;
                }
                let shadow = study.shadowed(stage, effort.radius, method, side, &reference)?;
                let ((seconds, layers), error) = (shadow.map, shadow.difference.mean);
                let nanoseconds = each(shadow.factors.seconds);
                sizes.push(SizeCost { method, side, seconds, layers, nanoseconds, error });
            }
        }
        Ok(Self { sizes, radii, left_out, scene, parameters: study.parameters() })
    }

    /// How many times longer a ray through the paper's layers takes in the
    /// largest map than in the smallest, and than in the one before.
    #[must_use]
    pub fn growth(&self) -> [f64; 2] {
        let own = self.sizes.iter().filter(|cost| cost.method == Method::Paper);
        let times: Vec<f64> = own.map(|cost| cost.nanoseconds).collect();
        match times.as_slice() {
            [first, .., before, last] => [last / first, last / before],
            [first, last] => [last / first; 2],
            _ => [f64::NAN; 2],
        }
    }

    /// The page and its plot.
    ///
    /// # Errors
    ///
    /// If the plot can't be drawn.
    pub fn page(&self) -> Result<Page> {
        let rows = self.sizes.iter().map(|cost| {
            vec![
                cost.method.name().to_owned(),
                cost.side.to_string(),
                format!("{:.2}", cost.seconds),
                format!("{:.2} M", cost.layers as f64 / 1e6),
                format!("{:.0}", cost.nanoseconds),
                format!("{:.4}", cost.error),
            ]
        });
        let sizes = table(
            &["map", "pixels a side", "made in s", "layers", "ns a ray", "mean difference"],
            rows,
        );
        let rows = self.radii.iter().map(|cost| {
            let mut cells = vec![cost.radius.to_string(), format!("{:.0}", cost.geometry)];
            cells.extend(cost.nanoseconds.iter().map(|time| format!("{time:.0}")));
            cells
        });
        let header = ["light radius", "geometry"].into_iter().chain(Method::ALL.map(Method::name));
        let radii = table(&header.collect::<Vec<_>>(), rows);
        let left_out = self.left_out.iter();
        let left_out: String = left_out
            .map(|(method, side)| {
                format!(
                    "Left out, since making it would have taken more than {PATIENCE} s: {side} × \
                     {side} pixels, {}.\n",
                    method.name()
                )
            })
            .collect();
        let by_size = |method: Method| {
            let own = self.sizes.iter().filter(|cost| cost.method == method);
            let points = own.map(|cost| (f64::from(cost.side), cost.nanoseconds)).collect();
            (method.name(), points)
        };
        let by_radius = |(index, method): (usize, Method)| {
            let points = self.radii.iter().map(|cost| (cost.radius, cost.nanoseconds[index]));
            (method.name(), points.collect())
        };
        let plot = svg(&[
            Panel {
                title: "Time of a ray",
                x: "pixels along the map's side",
                y: "ns",
                curves: vec![by_size(Method::Paper), by_size(Method::Fragments)],
            },
            Panel {
                title: "Time of a ray",
                x: "light radius",
                y: "ns",
                curves: Method::ALL.into_iter().enumerate().map(by_radius).collect(),
            },
        ])?;
        let [growth, last] = self.growth();
        let text = format!(
            include_str!("cost.md"),
            growth = growth,
            last = last,
            scene = self.scene,
            sizes = sizes,
            radii = radii,
            left_out = left_out,
            parameters = self.parameters,
        );
        let name = "soft-shadows-cost";
        let plot = (format!("results/{name}.svg"), plot.into_bytes());
        Ok(Page { name, text, pictures: vec![plot] })
    }
}
