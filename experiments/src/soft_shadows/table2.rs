//! Table 2: what soft shadows cost.

use anyhow::Result;

use super::{Effort, Method, Page, Study};
use crate::figures::table;

/// The paper's seconds for tracing maps, tracing geometry, PCF, and several views; NaN
/// where it has none.
const PAPER: [(&str, [f64; 4]); 3] = [
    ("head", [57.0, 207.0, 18.0, 273.0]),
    ("foliage", [61.0, 446.0, 20.0, 311.0]),
    ("hairball", [98.0, 2662.0, 33.0, f64::NAN]),
];

/// One scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Table2Row {
    /// The scene's name.
    pub scene: &'static str,
    /// Shaded points.
    pub points: usize,
    /// Seconds that tracing the scene took.
    pub geometry: f64,
    /// Seconds of every method, without making the map.
    pub seconds: Vec<(Method, f64)>,
    /// Mean differences from traced shadows.
    pub differences: Vec<f64>,
}

/// Table 2, measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Table2 {
    /// The scenes.
    pub rows: Vec<Table2Row>,
    rays: u32,
    parameters: String,
}

impl Table2 {
    /// Measures it.
    ///
    /// # Errors
    ///
    /// What the code under test says.
    pub fn measure(study: &mut Study) -> Result<Self> {
        let Effort { radius, rays, map, .. } = study.effort;
        let rows = (0..study.stages.len()).map(|stage| {
            let (scene, points) = (study.stages[stage].name, study.stages[stage].points.len());
            let lit = study.lit(stage, radius)?.clone();
            let views = study.shadowed(stage, radius, Method::Views, map, &lit.reference)?;
            let shadows = || lit.shadows.iter().chain([&views]);
            let seconds = shadows().map(|shadow| (shadow.method, shadow.factors.seconds)).collect();
            let differences = shadows().map(|shadow| shadow.difference.mean).collect();
            let geometry = lit.reference.seconds;
            Ok(Table2Row { scene, points, geometry, seconds, differences })
        });
        Ok(Self { rows: rows.collect::<Result<_>>()?, rays, parameters: study.parameters() })
    }

    /// The page.
    #[must_use]
    pub fn page(&self) -> Page {
        let methods = || Method::WITH_VIEWS.map(Method::name);
        let rows = self.rows.iter().map(|row| {
            let mut cells = vec![format!("`{}`", row.scene), format!("{:.2}", row.geometry)];
            cells.extend(row.seconds.iter().map(|(_, seconds)| format!("{seconds:.2}")));
            cells
        });
        let header: Vec<&str> = ["scene", "geometry"].into_iter().chain(methods()).collect();
        let seconds = table(&header, rows);
        let rows = self.rows.iter().map(|row| {
            let rays = row.points as f64 * f64::from(self.rays);
            let rate = |seconds: f64| format!("{:.2}", rays / seconds / 1e6);
            let mut cells = vec![format!("`{}`", row.scene), rate(row.geometry)];
            cells.extend(row.seconds.iter().map(|&(_, seconds)| rate(seconds)));
            cells
        });
        let rates = table(&header, rows);
        let rows = self.rows.iter().map(|row| {
            let differences = row.differences.iter().map(|difference| format!("{difference:.4}"));
            std::iter::once(format!("`{}`", row.scene)).chain(differences).collect()
        });
        let header: Vec<&str> = std::iter::once("scene").chain(methods()).collect();
        let differences = table(&header, rows);
        let rows = self.rows.iter().map(|row| {
            let paper = PAPER.iter().find(|(scene, _)| *scene == row.scene);
            let [map, geometry, filter, views] =
                paper.map_or([f64::NAN; 4], |(_, numbers)| *numbers);
            let own = |method| {
                let found = row.seconds.iter().find(|(own, _)| *own == method);
                found.map_or(f64::NAN, |(_, seconds)| *seconds)
            };
            vec![
                format!("`{}`", row.scene),
                format!("{:.1}", geometry / map),
                format!("{:.1}", row.geometry / own(Method::Paper)),
                format!("{:.1}", row.geometry / own(Method::Fragments)),
                format!("{:.1}", map / filter),
                format!("{:.1}", own(Method::Paper) / own(Method::Filter)),
                format!("{:.1}", own(Method::Fragments) / own(Method::Filter)),
                if views.is_nan() { "–".to_owned() } else { format!("{:.1}", views / map) },
                format!("{:.1}", own(Method::Views) / own(Method::Paper)),
                format!("{:.1}", own(Method::Views) / own(Method::Fragments)),
            ]
        });
        let ratios = table(
            &[
                "scene",
                "geometry / MTSM: paper",
                "K = 5, subtract",
                "fragments",
                "MTSM / PCF: paper",
                "K = 5, subtract",
                "fragments",
                "several views / MTSM: paper",
                "5 views / K = 5, subtract",
                "5 views / fragments",
            ],
            rows,
        );
        let text = format!(
            include_str!("table2.md"),
            seconds = seconds,
            rates = rates,
            differences = differences,
            ratios = ratios,
            parameters = self.parameters,
        );
        Page { name: "soft-shadows-table-2", text, pictures: Vec::new() }
    }
}
