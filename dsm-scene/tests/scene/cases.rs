//! Files of other programs' kinds, with the light that each must stop.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::Deserialize;

use crate::light::stopped_by;

/// A folder of files, or `None` with a note where there is none.
fn case_folder(name: &str) -> Option<PathBuf> {
    let path = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/cases")).join(name);
    if path.exists() {
        return Some(path);
    }
    println!("SKIPPED: {} is not there", path.display());
    None
}

#[derive(Deserialize)]
struct Expected {
    mesh: BTreeMap<String, f64>,
    gltf: BTreeMap<String, [f64; 2]>,
}

const TOLERANCE: f64 = 0.004;

#[test]
fn files_stop_the_light_that_they_say() {
    let Some(folder) = case_folder("") else { return };
    let expected = std::fs::read(folder.join("expect.json")).unwrap();
    let expected: Expected = serde_json::from_slice(&expected).unwrap();
    assert!(expected.mesh.len() > 10 && expected.gltf.len() > 10);
    let mut wrong = Vec::new();
    for (name, want) in &expected.mesh {
        match stopped_by(&folder.join("mesh").join(name)) {
            Ok(found) if (found.mean() - want).abs() <= TOLERANCE => {}
            other => wrong.push(format!("{name}: {want} and not {other:?}")),
        }
    }
    for (name, want) in &expected.gltf {
        match stopped_by(&folder.join("gltf").join(name)) {
            Ok(found) if (0..2).all(|at| (found.halves[at] - want[at]).abs() <= TOLERANCE) => {}
            other => wrong.push(format!("{name}: {want:?} and not {other:?}")),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn what_can_be_taken_in_two_ways_is_said() {
    let Some(folder) = case_folder("mesh") else { return };
    for (name, want, warning) in [
        ("tr_one.obj", 0.0, Some("Tr 1 without d")),
        ("edges_only.ply", 0.0, Some("no surface")),
        ("alpha.ply", 0.1, Some("alpha of vertices is taken for opacity: 0.2 to 0.2")),
        ("vertex_nan_unused.ply", 0.5, None),
        ("d_halo.obj", 0.25, Some("d -halo")),
    ] {
        let found = stopped_by(&folder.join(name)).unwrap();
        assert!((found.mean() - want).abs() <= TOLERANCE, "{name}: {found:?}");
        match warning {
            None => assert!(found.warnings.is_empty(), "{found:?}"),
            Some(warning) => assert!(
                found.warnings.len() == 1 && found.warnings[0].contains(warning),
                "{name}: {found:?}"
            ),
        }
    }
}

#[test]
fn strands_stop_the_same_light_however_they_are_cut() {
    let Some(folder) = case_folder("hair") else { return };
    for name in ["strand_1.hair", "strand_64.hair"] {
        let found = stopped_by(&folder.join(name)).unwrap();
        assert!((found.mean() - 0.0489).abs() <= TOLERANCE, "{name}: {found:?}");
    }
}
