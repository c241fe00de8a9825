//! The preview: maps of 64 points of the light, looked up, beside Embree's 64 rays.

use anyhow::Result;

use super::trial::{Attenuated, Difference, ask};
use crate::figures::table;
use crate::prefilter::page::Compared;

/// Points of the light, and rays of Embree a point.
const SAMPLES: u32 = 64;

/// Rays a point that Embree's time is told of.
pub(super) const TOLD: f64 = 256.0;

/// Lookups on the scenes of other programs.
pub(super) fn compare(scenes: &[Compared], sides: &[u32]) -> Result<String> {
    let mut rows = Vec::new();
    for Compared { peer, embree } in scenes {
        let light = peer.light()?;
        let reference: Vec<f32> = peer.reference.iter().map(|&factor| factor as f32).collect();
        for &side in sides {
            let map = Attenuated::new(&peer.scene, side, SAMPLES, 1.0)?;
            let four = map.shadow.clone().with_bilinear(true);
            let asked = [
                ("one texel", &map.shadow, &peer.points),
                ("one texel, normals", &map.shadow, &peer.on_surfaces),
                ("four texels, normals", &four, &peer.on_surfaces),
            ];
            for (name, shadow, points) in asked {
                let (found, micros) = ask(shadow, points, &light);
                let half = found.len() / 2;
                let part = |from: usize, to: usize| {
                    Difference::new(&found[from..to], &reference[from..to], 1)
                };
                let [ground, object] = [part(0, half), part(half, found.len())];
                let all = part(0, found.len());
                let times = embree.map(|embree| embree * f64::from(SAMPLES) / TOLD / micros);
                rows.push(vec![
                    peer.name.clone(),
                    format!("{side}²"),
                    name.to_owned(),
                    format!("{:.1}", map.seconds[0]),
                    format!("{:.4}", all.rmse),
                    format!("{:.4}", ground.rmse),
                    format!("{:.4}", object.rmse),
                    format!("{:+.4}", all.mean),
                    format!("{micros:.3}"),
                    times.map_or("–".to_owned(), |times| format!("{times:.0}")),
                ]);
            }
        }
    }
    let header = [
        "scene",
        "map",
        "lookups of",
        "map, s",
        "RMSE",
        "ground",
        "object",
        "mean",
        "µs a point",
        "times Embree, 64 rays",
    ];
    Ok(table(&header, rows))
}
