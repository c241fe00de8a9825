//! The left and the right of figure 10: what making maps takes, and how deep they get.

use anyhow::Result;
use dsm_scene::detail::SceneReference;

use super::trial::{Attenuated, Difference, ask};
use crate::figures::table;
use crate::soft_shadows::{Factors, Stage};

/// A number of points of the light.
pub(super) struct Row {
    samples: u32,
    map: Attenuated,
    /// By one texel, and by four.
    differences: [Difference; 2],
    micros: [f64; 2],
}

/// One point of the light after another, of a scene.
pub(super) struct Precomputation {
    pub(super) points: usize,
    pub(super) rows: Vec<Row>,
}

/// Shadows traced through the scene by 256 rays, of one point of every so many.
pub(super) fn reference(stage: &Stage, every: usize) -> Result<Factors> {
    let light = stage.scene.light.area()?;
    let tracer = SceneReference::<f32>::new(std::sync::Arc::clone(&stage.traced)).with_rays(256);
    let points: Vec<_> = stage.surfaces.iter().step_by(every).copied().collect();
    Ok(Stage::factors_of(&points, &tracer, &light))
}

impl Precomputation {
    /// Maps of `side` × `side` texels from so many points of the light each.
    pub(super) fn measure(
        stage: &Stage,
        side: u32,
        samples: &[u32],
        (reference, every): (&Factors, usize),
    ) -> Result<Self> {
        let light = stage.scene.light.area()?;
        let row = |&samples: &u32| {
            let map = Attenuated::new(&stage.scene, side, samples, 1.0)?;
            let four = map.shadow.clone().with_bilinear(true);
            let asked = [&map.shadow, &four].map(|shadow| ask(shadow, &stage.surfaces, &light));
            let differences =
                [0, 1].map(|at| Difference::new(&asked[at].0, &reference.values, every));
            let micros = [asked[0].1, asked[1].1];
            Ok(Row { samples, map, differences, micros })
        };
        let rows = samples.iter().map(row).collect::<Result<_>>()?;
        Ok(Self { points: stage.points.len(), rows })
    }

    /// The table of one scene.
    pub(super) fn table(&self) -> String {
        let rows = self.rows.iter().map(|row| {
            let [all, rendering] = row.map.seconds;
            let [one, four] = row.differences;
            vec![
                row.samples.to_string(),
                format!("{all:.2}"),
                format!("{rendering:.2}"),
                format!("{:.3}", row.map.complexity),
                format!("{:.2}", row.map.layers as f64 / 1e6),
                format!("{:.4}", one.rmse),
                format!("{:+.4}", one.mean),
                format!("{:.4}", four.rmse),
                format!("{:.0}", row.micros[0] * self.points as f64 / 1e3),
                format!("{:.0}", row.micros[1] * self.points as f64 / 1e3),
            ]
        });
        table(
            &[
                "light samples",
                "map, s",
                "of it rendering",
                "layers a texel",
                "million layers",
                "RMSE",
                "mean",
                "RMSE of four texels",
                "picture, ms",
                "of four texels, ms",
            ],
            rows,
        )
    }

    /// Layers a texel by number of samples.
    pub(super) fn complexities(&self) -> Vec<(f64, f64)> {
        self.rows.iter().map(|row| (f64::from(row.samples), row.map.complexity)).collect()
    }

    /// Seconds by number of samples.
    pub(super) fn seconds(&self) -> Vec<(f64, f64)> {
        self.rows.iter().map(|row| (f64::from(row.samples), row.map.seconds[0])).collect()
    }
}
