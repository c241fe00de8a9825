//! Table 3: what the maps cost, and what more layers do.

use anyhow::Result;

use super::{Effort, Method, Page, Study};
use crate::figures::table;

/// The methods whose maps are compared.
const METHODS: [Method; 4] = [Method::Single, Method::Paper, Method::Ratio, Method::Fragments];

/// A map of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapCost {
    /// The method.
    pub method: Method,
    /// Seconds to make it.
    pub seconds: f64,
    /// Its layers.
    pub layers: usize,
    /// Seconds to trace it.
    pub trace: f64,
}

/// One scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Table3Row {
    /// The scene's name.
    pub scene: &'static str,
    /// Shaded points.
    pub points: usize,
    /// Triangles and segments of strands.
    pub primitives: usize,
    /// The maps: one layer, five, up to 32, and fragments.
    pub maps: Vec<MapCost>,
}

/// Table 3, measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Table3 {
    /// The scenes.
    pub rows: Vec<Table3Row>,
    parameters: String,
}

impl Table3 {
    /// Measures it.
    ///
    /// # Errors
    ///
    /// What the code under test says.
    pub fn measure(study: &mut Study) -> Result<Self> {
        let Effort { radius, .. } = study.effort;
        let rows = (0..study.stages.len()).map(|index| {
            let stage = &study.stages[index];
            let (scene, points, primitives) = (stage.name, stage.points.len(), stage.primitives());
            let lit = study.lit(index, radius)?;
            let maps = METHODS.map(|method| {
                let shadow = lit.by(method)?;
                let (seconds, layers) = shadow.map;
                Ok(MapCost { method, seconds, layers, trace: shadow.factors.seconds })
            });
            let maps = maps.into_iter().collect::<Result<_>>()?;
            Ok(Table3Row { scene, points, primitives, maps })
        });
        Ok(Self { rows: rows.collect::<Result<_>>()?, parameters: study.parameters() })
    }

    /// The page.
    #[must_use]
    pub fn page(&self) -> Page {
        let rows = self.rows.iter().flat_map(|row| {
            row.maps.iter().map(|map| {
                vec![
                    format!("`{}`", row.scene),
                    format!("{:.1}k", row.points as f64 / 1e3),
                    format!("{:.0}k", row.primitives as f64 / 1e3),
                    map.method.name().to_owned(),
                    format!("{:.2}", map.seconds),
                    format!("{:.2} M", map.layers as f64 / 1e6),
                    format!("{:.2}", map.trace),
                ]
            })
        });
        let costs = table(
            &["scene", "points", "primitives", "map", "made in s", "layers", "traced in s"],
            rows,
        );
        let rows = self.rows.iter().filter_map(|row| {
            let [one, five, ..] = row.maps.as_slice() else { return None };
            Some(vec![
                format!("`{}`", row.scene),
                format!("{:.2}", five.seconds / one.seconds),
                format!("{:.2}", five.trace / one.trace),
            ])
        });
        let layers = table(&["scene", "making: K = 5 / K = 1", "tracing: K = 5 / K = 1"], rows);
        let text = format!(
            include_str!("table3.md"),
            costs = costs,
            layers = layers,
            parameters = self.parameters,
        );
        Page { name: "soft-shadows-table-3", text, pictures: Vec::new() }
    }
}
