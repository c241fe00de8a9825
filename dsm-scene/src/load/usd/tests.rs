//! Stages against what usd-core reads in them: `tests/data/usd/make.py` has written
//! both.

use std::path::{Path, PathBuf};

use glam::DVec3;
use serde::Deserialize;

use super::geometry::{Geometry, Item, items};
use super::location::Location;
use super::stage::Stage;
use crate::error::Result;
use crate::load::warnings::Warnings;

#[derive(Deserialize)]
struct Expected {
    stage: Vec<ExpectedStage>,
}

#[derive(Deserialize)]
struct ExpectedStage {
    time: Option<f64>,
    #[serde(default)]
    item: Vec<ExpectedItem>,
}

#[derive(Deserialize)]
struct ExpectedItem {
    path: String,
    kind: String,
    #[serde(default)]
    faces: Vec<usize>,
    #[serde(default)]
    lengths: Vec<usize>,
    corners: Vec<f64>,
    #[serde(default)]
    widths: Vec<f64>,
    opacities: Vec<f32>,
}

impl ExpectedItem {
    fn corners(&self) -> Vec<DVec3> {
        self.corners.as_chunks::<3>().0.iter().map(|&corner| DVec3::from(corner)).collect()
    }
}

fn data() -> PathBuf {
    // More stages than the repository has, made by the same program.
    match std::env::var_os("DSM_USD_STAGES") {
        Some(folder) => folder.into(),
        None => Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/usd"),
    }
}

fn read(path: &Path, time: Option<f64>) -> Result<(Vec<Item>, Vec<String>)> {
    let mut warnings = Warnings::default();
    let items = items(&mut Stage::open(Location::of_file(path), &mut warnings)?, time)?;
    Ok((items, warnings.into_lines()))
}

/// Compares a mesh: each polygon's triangles have its corners and opacities.
fn compare_mesh(found: &Item, expected: &ExpectedItem, near: &impl Fn(DVec3, DVec3) -> bool) {
    let Geometry::Mesh { positions, triangles, opacities } = &*found.shape else {
        panic!("{} is no mesh", expected.path)
    };
    let count: usize = expected.faces.iter().map(|face| face.saturating_sub(2)).sum();
    assert_eq!(triangles.len(), count, "{}", expected.path);
    let (mut corners, mut triangles) = (&expected.corners()[..], &triangles[..]);
    let mut expected_opacities = &expected.opacities[..];
    for &face in &expected.faces {
        let (own, after) = corners.split_at(face);
        let (own_opacities, opacities_after) = expected_opacities.split_at(face);
        let (cut, triangles_after) = triangles.split_at(face.saturating_sub(2));
        let mut is_used = vec![false; face];
        for &vertex in cut.iter().flatten() {
            let point = positions[vertex as usize].as_dvec3();
            let point = found.to_world.transform_point3(point);
            let opacity = match opacities.get(vertex as usize) {
                Some(&opacity) => opacity,
                None => found.inherited.unwrap_or(1.0),
            };
            let is_corner = |&corner: &usize| {
                near(own[corner], point) && (own_opacities[corner] - opacity).abs() < 1e-6
            };
            let matching: Vec<usize> = (0..face).filter(is_corner).collect();
            assert!(!matching.is_empty(), "{}: {point} {opacity}", expected.path);
            matching.into_iter().for_each(|corner| is_used[corner] = true);
        }
        assert!(is_used.iter().all(|&used| used), "{}", expected.path);
        (corners, triangles, expected_opacities) = (after, triangles_after, opacities_after);
    }
}

/// Compares strands: each place on a curve is on its strand, which is as thick there.
fn compare_strands(found: &Item, expected: &ExpectedItem, scale: f64) {
    let Geometry::Strands { points, radii, opacities, lengths } = &*found.shape else {
        panic!("{} is no strand", expected.path)
    };
    let widen = found.to_world.matrix3.determinant().abs().cbrt();
    let strand: Vec<(DVec3, f64, f32)> = (0..points.len())
        .map(|at| {
            let point = found.to_world.transform_point3(points[at].as_dvec3());
            let opacity = opacities.get(at).copied();
            (point, f64::from(radii[at]) * widen, opacity.or(found.inherited).unwrap_or(1.0))
        })
        .collect();
    let corners = expected.corners();
    let wanted: Vec<usize> = match expected.kind.as_str() {
        "Points" => vec![1; corners.len()],
        _ => expected.lengths.iter().copied().filter(|&length| length > 0).collect(),
    };
    assert_eq!(lengths.len(), wanted.len(), "{}", expected.path);
    let (mut at, mut start) = (0, 0);
    for (&length, &wanted) in lengths.iter().zip(&wanted) {
        let own = &strand[start..start + length as usize];
        start += length as usize;
        for (index, &place) in corners.iter().enumerate().skip(at).take(wanted) {
            let radius = expected.widths[index] / 2.0;
            let opacity = expected.opacities[index];
            let largest = own.iter().map(|point| point.1).fold(radius, f64::max);
            let error = own
                .windows(2)
                .map(|pair| {
                    let along = pair[1].0 - pair[0].0;
                    let part = (place - pair[0].0).dot(along) / along.length_squared();
                    let part = if part.is_finite() { part.clamp(0.0, 1.0) } else { 0.0 };
                    let off = pair[0].0.lerp(pair[1].0, part).distance(place);
                    let thick = pair[0].1 + (pair[1].1 - pair[0].1) * part;
                    let dim = pair[0].2 + (pair[1].2 - pair[0].2) * part as f32;
                    let clarity = f64::from((dim - opacity).abs());
                    // A strand that bends or swells is so near in as many pieces as allowed.
                    (off / (largest / 4.0 + scale * 1e-6))
                        .max((thick - radius).abs() / (largest / 8.0 + scale * 1e-6))
                        .max(clarity / 0.05)
                })
                .fold(f64::INFINITY, f64::min);
            assert!(error <= 1.0, "{}: {place} {radius} {opacity}: {error}", expected.path);
        }
        at += wanted;
    }
    assert_eq!(at, corners.len(), "{}", expected.path);
}

/// The number of shapes compared.
fn compare(path: &Path, expected: &ExpectedStage) -> usize {
    let (found, warnings) = read(path, expected.time).unwrap();
    let paths = |items: &mut dyn Iterator<Item = String>| items.collect::<Vec<_>>();
    let name = path.display();
    let found_paths = paths(&mut found.iter().map(|item| item.path.to_string()));
    let expected_paths = paths(&mut expected.item.iter().map(|item| item.path.clone()));
    let at_time = expected.time;
    assert_eq!(found_paths, expected_paths, "{name} at {at_time:?}: {warnings:?}");
    let all = expected.item.iter().flat_map(|item| &item.corners);
    let scale = all.fold(0.0_f64, |scale, &number| scale.max(number.abs()));
    let near = |a: DVec3, b: DVec3| a.distance(b) <= 1e-6 * scale;
    for (found, expected) in found.iter().zip(&expected.item) {
        if expected.kind == "Mesh" {
            compare_mesh(found, expected, &near);
        } else {
            compare_strands(found, expected, scale);
        }
    }
    found.len()
}

#[test]
fn every_encoding_is_read_as_usd_core_does() {
    let mut compared = 0;
    for entry in std::fs::read_dir(data()).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|end| end != "toml") {
            continue;
        }
        let name = path.file_stem().unwrap().to_str().unwrap();
        let expected = std::fs::read_to_string(&path).unwrap();
        let expected: Expected = toml::from_str(&expected).unwrap();
        for (folder, end) in [("text", "usda"), ("binary", "usdc"), ("packed", "usdz")] {
            let path = data().join(folder).join(format!("{name}.{end}"));
            compared += expected.stage.iter().map(|stage| compare(&path, stage)).sum::<usize>();
        }
    }
    println!("{compared} shapes compared");
    assert!(compared > 200, "{compared}");
}
