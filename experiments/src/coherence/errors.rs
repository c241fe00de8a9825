//! Figure 9: what coherent sampling misses, against the densities of receivers and of the
//! light's samples.

use anyhow::Result;
use dsm_core::{AreaLight, Facing, ShadedPoint};
use dsm_scene::detail::SceneReference;
use dsm_scene::{Object, Scene, Shape, TracedScene, TriangleMesh, builtin_scene};
use dsm_trace::detail::CoherenceSettings;
use glam::{DVec3, Vec3};

use super::measured::Measured;
use crate::figures::table;

/// A light of 2 × 2 above the middle.
fn light() -> AreaLight {
    AreaLight::rectangle(DVec3::Y * 4.0, DVec3::X, DVec3::Z)
}

/// `side` × `side` points of the ground, 2 × 2 large.
fn ground(side: u32) -> Vec<ShadedPoint> {
    let at = |index: u32| (f64::from(index) + 0.5) / f64::from(side) * 2.0 - 1.0;
    (0..side * side)
        .map(|index| ShadedPoint {
            position: DVec3::new(at(index % side), 0.0, at(index / side)),
            facing: Facing::Light,
            seed: index.into(),
        })
        .collect()
}

/// Squares with these corners, all at one height.
fn squares(height: f32, squares: &[[f32; 4]]) -> Result<Object> {
    let corners = |&[left, back, right, front]: &[f32; 4]| {
        [(left, back), (right, back), (right, front), (left, front)]
            .map(|(x, z)| Vec3::new(x, height, z))
    };
    let positions = squares.iter().flat_map(corners).collect();
    let faces = (0..squares.len() as u32).map(|index| 4 * index);
    let faces =
        faces.flat_map(|first| [[0, 1, 2], [0, 2, 3]].map(|face| face.map(|at| first + at)));
    Ok(Object::new(Shape::Mesh(TriangleMesh::new(positions, faces.collect())?)))
}

fn traced(objects: Vec<Object>) -> Result<SceneReference<f32>> {
    let scene: Scene = builtin_scene("pipes")?.with_objects(objects);
    Ok(SceneReference::new(TracedScene::new(&scene)?))
}

/// Flakes that a receiver sees inside the light's outline, or not at all.
fn flakes() -> Result<SceneReference<f32>> {
    let places = (0..49_u8).map(|index| [index % 7, index / 7].map(|at| f32::from(at) * 0.3 - 0.9));
    let flakes: Vec<[f32; 4]> =
        places.map(|[x, z]| [x - 0.01, z - 0.01, x + 0.01, z + 0.01]).collect();
    traced(vec![squares(0.5, &flakes)?])
}

/// Two sheets with a slit each, across each other: what lies behind both holes sees a spot
/// of the light, whose border is blocked everywhere.
fn holes() -> Result<SceneReference<f32>> {
    let slit = 0.04;
    let lower = squares(1.0, &[[-3.0, -3.0, -slit, 3.0], [slit, -3.0, 3.0, 3.0]])?;
    let upper = squares(2.0, &[[-3.0, -3.0, 3.0, -slit], [-3.0, slit, 3.0, 3.0]])?;
    traced(vec![lower, upper])
}

/// The table of both.
///
/// # Errors
///
/// What a scene is not.
pub(super) fn compare(receivers: &[u32], cells: &[u32]) -> Result<String> {
    let scenes = [("missed blockers: 49 flakes", flakes()?), ("missed holes: two slits", holes()?)];
    let mut rows = Vec::new();
    for (name, tracer) in &scenes {
        for &side in receivers {
            for &cells in cells {
                let groups = [ground(side)];
                let settings = CoherenceSettings::new(cells);
                let found = Measured::new(tracer, &groups, &light(), settings);
                let sampling = [format!("{side} × {side}"), format!("{}", cells * cells)];
                let numbers = [
                    format!("{:.0} %", 100.0 * found.share()),
                    format!("{:.4}", found.difference.rmse),
                    format!("{:+.4}", found.difference.mean),
                ];
                let name = [(*name).to_owned()];
                rows.push(name.into_iter().chain(sampling).chain(numbers).collect());
            }
        }
    }
    Ok(table(&["", "receivers", "cells", "rays", "RMSE", "mean"], rows))
}
