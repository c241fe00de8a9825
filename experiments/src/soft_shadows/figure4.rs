//! Figure 4: how errors grow with the light.

use anyhow::Result;

use super::{Method, Page, Study};
use crate::figures::{Panel, svg, table};

/// A scene under one light.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure4Row {
    /// The scene's name.
    pub scene: &'static str,
    /// The light's radius.
    pub radius: f64,
    /// The mean absolute difference, by method.
    pub errors: Vec<f64>,
}

/// Figure 4, measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure4 {
    /// By scene, then by radius, ascending.
    pub rows: Vec<Figure4Row>,
    parameters: String,
}

impl Figure4 {
    /// Measures it.
    ///
    /// # Errors
    ///
    /// What the code under test says.
    pub fn measure(study: &mut Study) -> Result<Self> {
        let mut rows = Vec::new();
        for stage in 0..study.stages.len() {
            for radius in study.effort.radii.clone() {
                let scene = study.stages[stage].name;
                let lit = study.lit(stage, radius)?;
                let errors = lit.shadows.iter().map(|shadow| shadow.difference.mean).collect();
                rows.push(Figure4Row { scene, radius, errors });
            }
        }
        Ok(Self { rows, parameters: study.parameters() })
    }

    /// The rows of one scene.
    pub fn of<'a>(&'a self, scene: &'a str) -> impl Iterator<Item = &'a Figure4Row> {
        self.rows.iter().filter(move |row| row.scene == scene)
    }

    /// How many times larger the errors are under the largest light than under
    /// the smallest, by method.
    #[must_use]
    pub fn growth(&self, scene: &str) -> Vec<f64> {
        let (first, last) = (self.of(scene).next(), self.of(scene).last());
        let pairs = first.zip(last).into_iter();
        pairs.flat_map(|(a, b)| a.errors.iter().zip(&b.errors).map(|(a, b)| b / a)).collect()
    }

    fn scenes(&self) -> Vec<&'static str> {
        let mut scenes: Vec<_> = self.rows.iter().map(|row| row.scene).collect();
        scenes.dedup();
        scenes
    }

    /// The page and its plot.
    ///
    /// # Errors
    ///
    /// If the plot can't be drawn.
    pub fn page(&self) -> Result<Page> {
        let header = |first: &[&'static str]| -> Vec<&str> {
            first.iter().copied().chain(Method::ALL.map(Method::name)).collect()
        };
        let rows = self.rows.iter().map(|row| {
            let mut cells = vec![format!("`{}`", row.scene), row.radius.to_string()];
            cells.extend(row.errors.iter().map(|error| format!("{error:.4}")));
            cells
        });
        let numbers = table(&header(&["scene", "radius"]), rows);
        let scenes = self.scenes();
        let growth = scenes.iter().map(|scene| {
            let growth = self.growth(scene).into_iter().map(|growth| format!("{growth:.1}"));
            std::iter::once(format!("`{scene}`")).chain(growth).collect()
        });
        let growth = table(&header(&["scene"]), growth);
        let panels: Vec<Panel> = scenes
            .iter()
            .map(|scene| {
                let curve = |(index, method): (usize, Method)| {
                    // A logarithm's least.
                    let points =
                        self.of(scene).map(|row| (row.radius, row.errors[index].max(1e-6)));
                    (method.name(), points.collect())
                };
                let curves = Method::ALL.into_iter().enumerate().map(curve).collect();
                Panel { title: scene, x: "light radius", y: "mean difference", curves }
            })
            .collect();
        let text = format!(
            include_str!("figure4.md"),
            numbers = numbers,
            growth = growth,
            parameters = self.parameters,
        );
        let name = "soft-shadows-figure-4";
        let plot = (format!("results/{name}.svg"), svg(&panels)?.into_bytes());
        Ok(Page { name, text, pictures: vec![plot] })
    }
}
