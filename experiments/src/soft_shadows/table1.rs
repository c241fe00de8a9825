//! Table 1: how far soft shadows are from ray traced ones.

use anyhow::Result;

use super::{Difference, Method, Page, Study};
use crate::figures::table;

/// The paper's rows for Shrek, palm and fur ball: mean and standard deviation of
/// PCF, and of traced multilayer maps.
const PAPER: [(&str, [[f64; 2]; 2]); 3] = [
    ("head", [[0.063, 0.042], [0.0044, 0.005]]),
    ("foliage", [[0.017, 0.014], [0.003, 0.003]]),
    ("hairball", [[0.016, 0.05], [0.005, 0.002]]),
];

/// One scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Table1Row {
    /// The scene's name.
    pub scene: &'static str,
    /// By method.
    pub differences: Vec<(Method, Difference)>,
    /// With a map of fragments twice as wide and high.
    pub finer: Difference,
    /// The bias of PCF and the threshold of the paper's tracing that were
    /// closest: see [`super::Shadowed::knob`].
    pub knobs: [f64; 2],
    /// The mean of the traced factors.
    pub light: f64,
}

impl Table1Row {
    /// The mean difference of one method.
    #[must_use]
    pub fn mean(&self, method: Method) -> f64 {
        let found = self.differences.iter().find(|(own, _)| *own == method);
        found.map_or(f64::NAN, |(_, difference)| difference.mean)
    }

    /// The paper's numbers for such a scene.
    fn paper(&self) -> [[f64; 2]; 2] {
        let found = PAPER.iter().find(|(scene, _)| *scene == self.scene);
        found.map_or([[f64::NAN; 2]; 2], |(_, numbers)| *numbers)
    }
}

/// Table 1, measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Table1 {
    /// The scenes.
    pub rows: Vec<Table1Row>,
    radius: f64,
    parameters: String,
}

impl Table1 {
    /// Measures it.
    ///
    /// # Errors
    ///
    /// What the code under test says.
    pub fn measure(study: &mut Study) -> Result<Self> {
        let radius = study.effort.radius;
        let rows = (0..study.stages.len()).map(|stage| {
            let scene = study.stages[stage].name;
            let lit = study.lit(stage, radius)?.clone();
            let side = 2 * study.effort.fragment_map;
            let finer =
                study.shadowed(stage, radius, Method::Fragments, side, &lit.reference)?.difference;
            let knobs = [lit.by(Method::Filter)?.knob, lit.by(Method::Paper)?.knob];
            let values = &lit.reference.values;
            let light = values.iter().map(|&value| f64::from(value)).sum::<f64>();
            let light = light / values.len().max(1) as f64;
            let shadows = lit.shadows.iter();
            let differences = shadows.map(|shadow| (shadow.method, shadow.difference)).collect();
            Ok(Table1Row { scene, differences, finer, knobs, light })
        });
        let rows = rows.collect::<Result<_>>()?;
        Ok(Self { rows, radius, parameters: study.parameters() })
    }

    /// The page.
    #[must_use]
    pub fn page(&self) -> Page {
        let cell = |[mean, deviation]: [f64; 2]| format!("{mean:.4} ± {deviation:.4}");
        let rows = self.rows.iter().map(|row| {
            let mut cells = vec![format!("`{}`", row.scene)];
            let [filter, traced] = row.paper();
            cells.extend([cell(filter), cell(traced)]);
            let own = row.differences.iter();
            cells.extend(own.map(|(_, d)| cell([d.mean, d.deviation])));
            cells.push(cell([row.finer.mean, row.finer.deviation]));
            cells
        });
        let mut header = vec!["scene", "paper: PCF", "paper: MTSM"];
        header.extend(Method::ALL.map(Method::name));
        header.push("fragments, twice as fine");
        let numbers = table(&header, rows);
        let signed = self.rows.iter().map(|row| {
            let mut cells = vec![format!("`{}`", row.scene), format!("{:.3}", row.light)];
            cells.extend(row.knobs.map(|knob| knob.to_string()));
            cells.extend(row.differences.iter().map(|(_, d)| format!("{:+.4}", d.signed)));
            cells
        });
        let mut header = vec!["scene", "mean factor", "PCF's bias", "threshold"];
        header.extend(Method::ALL.map(Method::name));
        let signed = table(&header, signed);
        let goals = self.rows.iter().map(|row| {
            let mut cells = vec![format!("`{}`", row.scene)];
            let means = [Method::Paper, Method::Ratio, Method::Fragments].map(|m| row.mean(m));
            for mean in means.into_iter().chain([row.finer.mean]) {
                let share = mean / row.mean(Method::Filter);
                let of_paper = mean / row.paper()[1][0];
                cells.push(format!("{:.0} %{}", 100.0 * share, mark(share <= 0.1)));
                cells.push(format!("{of_paper:.2}{}", mark(of_paper <= 0.5)));
            }
            cells
        });
        let goals = table(
            &[
                "scene",
                "K = 5, subtract: of PCF's",
                "of the paper's",
                "K = 32, ratio: of PCF's",
                "of the paper's",
                "fragments: of PCF's",
                "of the paper's",
                "twice as fine: of PCF's",
                "of the paper's",
            ],
            goals,
        );
        let text = format!(
            include_str!("table1.md"),
            numbers = numbers,
            signed = signed,
            goals = goals,
            radius = self.radius,
            parameters = self.parameters,
        );
        Page { name: "soft-shadows-table-1", text, pictures: Vec::new() }
    }
}

/// A sign that a goal is reached.
const fn mark(reached: bool) -> &'static str {
    if reached { " ✓" } else { "" }
}
