//! What the error of attenuation maps of leaves comes from.

use anyhow::Result;

use super::trial::{Attenuated, Difference, ask};
use crate::figures::table;
use crate::soft_shadows::{Factors, Stage};

/// A way to make and to ask a map.
struct Trial {
    name: &'static str,
    /// Times as many texels along a side.
    finer: u32,
    samples: u32,
    /// In sides of a texel.
    tolerance: f64,
    /// In sides of a texel; None: as lookups have it.
    bias: Option<f64>,
    normals: bool,
    bilinear: bool,
}

const DEFAULT: Trial = Trial {
    name: "defaults",
    finer: 1,
    samples: 64,
    tolerance: 1.0,
    bias: None,
    normals: true,
    bilinear: false,
};

/// All of them, the first by itself.
fn trials() -> Vec<Trial> {
    vec![
        DEFAULT,
        Trial { name: "without normals", normals: false, ..DEFAULT },
        Trial { name: "four texels", bilinear: true, ..DEFAULT },
        Trial { name: "bias 0.5 texels", bias: Some(0.5), ..DEFAULT },
        Trial { name: "bias 1 texel", bias: Some(1.0), ..DEFAULT },
        Trial { name: "bias 4 texels", bias: Some(4.0), ..DEFAULT },
        Trial { name: "16 light samples", samples: 16, ..DEFAULT },
        Trial { name: "tolerance 4 texels", tolerance: 4.0, ..DEFAULT },
        Trial { name: "twice as fine, 16 light samples", finer: 2, samples: 16, ..DEFAULT },
        Trial { name: "4 times as fine, 16 light samples", finer: 4, samples: 16, ..DEFAULT },
    ]
}

/// How wide a texel is where the light looks, in scene units.
fn texel(stage: &Stage, map: &Attenuated) -> f64 {
    let view = &stage.scene.light.view;
    map.shadow.frame().footprint((view.target - view.eye).length())
}

/// The table of one scene: over all points, those of the floor and those above it.
pub(super) fn compare(
    stage: &Stage,
    (side, most): (u32, u32),
    (reference, every): (&Factors, usize),
) -> Result<String> {
    let light = stage.scene.light.area()?;
    let points: Vec<_> = stage.surfaces.iter().step_by(every).copied().collect();
    let unknown: Vec<_> = stage.points.iter().step_by(every).copied().collect();
    let mut rows = Vec::new();
    // The map of the trial before, if it is one that this needs.
    let mut last: Option<(u32, u32, f64, Attenuated)> = None;
    for trial in trials() {
        let side = side * trial.finer;
        let samples = trial.samples.min(most);
        let key = (side, samples, trial.tolerance);
        let known = last
            .take()
            .filter(|(side, samples, tolerance, _)| (*side, *samples, *tolerance) == key);
        let map = match known {
            Some((.., map)) => map,
            None => Attenuated::new(&stage.scene, side, samples, trial.tolerance)?,
        };
        let wide = texel(stage, &map);
        let mut shadow = map.shadow.clone().with_bilinear(trial.bilinear);
        if let Some(bias) = trial.bias {
            shadow = shadow.with_bias(bias * wide)?;
        }
        let (found, _) = ask(&shadow, if trial.normals { &points } else { &unknown }, &light);
        let part = |on_floor: bool| {
            let picked = points.iter().zip(found.iter().zip(&reference.values));
            // The floor is at 0, where points are moved off it by rounding.
            let picked = picked.filter(|(point, _)| (point.position.y < 1e-6) == on_floor);
            let (found, wanted): (Vec<f32>, Vec<f32>) = picked.map(|(_, (&a, &b))| (a, b)).unzip();
            (Difference::new(&found, &wanted, 1), found, wanted)
        };
        let (all, (floor, ..), (object, found, wanted)) =
            (Difference::new(&found, &reference.values, 1), part(true), part(false));
        let dark = found.iter().zip(&wanted).filter(|&(&a, &b)| a == 0.0 && b > 0.25).count();
        let dark = 100.0 * dark as f64 / found.len().max(1) as f64;
        rows.push(vec![
            trial.name.to_owned(),
            format!("{:.4}", all.rmse),
            format!("{:.4}", floor.rmse),
            format!("{:.4}", object.rmse),
            format!("{:+.4}", object.mean),
            format!("{dark:.1} %"),
            format!("{wide:.4}"),
        ]);
        last = Some((side, samples, trial.tolerance, map));
    }
    let header = ["", "RMSE", "floor", "object", "mean, object", "no layer, but lit", "a texel"];
    Ok(table(&header, rows))
}
