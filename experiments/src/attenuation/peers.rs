//! Several views traced on the scenes of other programs, beside other maps.

use anyhow::Result;
use dsm_core::ShadedPoint;
use shadow_maps::detail::{ViewsTracer, view_points};

use super::accelerations::{compare as accelerations, trace};
use super::lookups::TOLD;
use super::trial::{Difference, ask};
use crate::figures::table;
use crate::prefilter::page::Compared;
use crate::prefilter::peer::PeerScene;
use crate::soft_shadows::{Map, Method, views};

/// Numbers of views that are tried.
pub(super) const VIEWS: [u32; 3] = [2, 4, 9];

/// Views of a scene from so many points of its light.
pub(crate) fn tracer(scene: &dsm_scene::Scene, side: u32, count: u32) -> Result<ViewsTracer> {
    let points = view_points(&scene.light.area()?, scene.light.view.target, count);
    views(scene, scene.light.raster([side; 2])?, points)
}

/// A row, and the numbers that all have.
fn row(name: String, found: Difference, rate: f64, embree: Option<f64>) -> Vec<String> {
    vec![
        name,
        format!("{:.4}", found.rmse),
        format!("{:+.4}", found.mean),
        format!("{rate:.2}"),
        embree.map_or("–".to_owned(), |embree| format!("{:.2}", rate * embree / TOLD)),
    ]
}

/// Several views beside Embree, maps of layers and of fragments, by `rays` rays a point.
pub(super) fn compare(
    Compared { peer, embree }: &Compared,
    (side, rays): (u32, u32),
) -> Result<String> {
    let light = peer.light()?;
    let reference: Vec<f32> = peer.reference.iter().map(|&factor| factor as f32).collect();
    let mut rows = Vec::new();
    for count in VIEWS {
        let tracer = tracer(&peer.scene, side, count)?;
        let traced = trace(&tracer, &peer.points, &light, rays, &reference);
        rows.push(row(format!("{count} views"), traced.difference, traced.rate, *embree));
    }
    for method in [Method::Paper, Method::Ratio, Method::Fragments] {
        let map = Map::new(&peer.scene, &peer.scene.light, method, side)?;
        // The thresholds that suit pictures of other scenes; the closer one counts.
        let tried = map.knobs().iter().map(|&knob| {
            map.with_shadow(&light, rays, knob, |shadow| ask(shadow, &peer.points, &light))
        });
        let tried = tried.collect::<Result<Vec<_>>>()?.into_iter();
        let tried = tried.map(|(found, micros)| {
            (Difference::new(&found, &reference, 1), f64::from(rays) / micros)
        });
        if let Some((found, rate)) = tried.min_by(|a, b| a.0.rmse.total_cmp(&b.0.rmse)) {
            let name = match method {
                Method::Fragments => "fragments".to_owned(),
                other => format!("MTSM, {}", other.name()),
            };
            rows.push(row(name, found, rate, *embree));
        }
    }
    if let Some(embree) = embree {
        rows.push(row("Embree".to_owned(), Difference::default(), TOLD / embree, Some(*embree)));
    }
    Ok(table(&["", "RMSE", "mean", "million rays/s", "of Embree's"], rows))
}

/// Each acceleration on a scene of other programs, of every so manieth point.
pub(super) fn each_acceleration(
    peer: &PeerScene,
    (side, rays): (u32, u32),
    every: usize,
) -> Result<String> {
    let tracer = tracer(&peer.scene, side, 4)?;
    let points: Vec<ShadedPoint> = peer.points.iter().step_by(every).copied().collect();
    let reference: Vec<f32> =
        peer.reference.iter().step_by(every).map(|&factor| factor as f32).collect();
    Ok(accelerations(&tracer, &points, &peer.light()?, rays, &reference))
}
