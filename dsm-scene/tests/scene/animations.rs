//! glTF files at a time of an animation.

use std::fs;

use glam::{DQuat, Quat, Vec3};
use serde_json::{Value, json};

use crate::document::Document;
use crate::light::{Stopped, stopped_by};
use dsm_scene::detail::Result;
use dsm_scene::{Scene, Shape, open_scene};

/// A document with a scene file that asks for it with these keys.
fn scene(document: &mut Document, keys: &str) -> (tempfile::TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    document.write(&folder.path().join("a.gltf"));
    let path = folder.path().join("scene.toml");
    fs::write(&path, format!("[[object]]\nmesh = \"a.gltf\"\n{keys}")).unwrap();
    (folder, path)
}

fn stopped(document: &mut Document, keys: &str) -> Result<Stopped> {
    let (_folder, path) = scene(document, keys);
    stopped_by(&path)
}

/// Of its only object, the corners.
fn corners(document: &mut Document, keys: &str) -> Vec<Vec3> {
    let (_folder, path) = scene(document, keys);
    let scene: Scene = open_scene(&path).unwrap();
    let corners = match &*scene.objects[0].shape {
        Shape::Mesh(mesh) => mesh.positions().to_vec(),
        _ => Vec::new(),
    };
    assert_eq!(corners.len(), 4);
    corners
}

/// Adds an animation of one property of node 0.
fn animate(document: &mut Document, path: &str, interpolation: &str, keys: &[f32], values: &[f32]) {
    let input = document.floats("SCALAR", keys);
    let kind = match path {
        "rotation" => "VEC4",
        "weights" => "SCALAR",
        _ => "VEC3",
    };
    let output = document.floats(kind, values);
    let animation = json!({
        "samplers": [{"input": input, "output": output, "interpolation": interpolation}],
        "channels": [{"sampler": 0, "target": {"node": 0, "path": path}}],
    });
    match &mut document.json["animations"] {
        Value::Array(animations) => animations.push(animation),
        missing => *missing = json!([animation]),
    }
}

#[test]
fn a_node_moves_between_its_keyframes() {
    let values = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0];
    for (interpolation, time, right) in [
        ("LINEAR", "1.0", 0.0),
        ("LINEAR", "2.0", 0.25),
        ("LINEAR", "5.0", 1.0),
        ("LINEAR", "50.0", 1.0),
        ("LINEAR", "-50", 0.0),
        ("STEP", "4.99", 0.0),
        ("STEP", "5", 1.0),
    ] {
        let mut document = Document::new();
        animate(&mut document, "translation", interpolation, &[1.0, 5.0], &values);
        let found = stopped(&mut document, &format!("time = {time}\n")).unwrap();
        assert!((found.halves[1] - right).abs() < 0.01, "{interpolation} {time}: {found:?}");
        assert!((found.halves[0] - (1.0 - right)).abs() < 0.01, "{found:?}");
        assert!(found.warnings.is_empty(), "{found:?}");
    }
    let mut document = Document::new();
    animate(&mut document, "translation", "LINEAR", &[1.0, 5.0], &values);
    let found = stopped(&mut document, "").unwrap();
    assert_eq!(found.halves, [1.0, 0.0]);
    assert!(found.warnings[0].contains("animations are not applied"), "{found:?}");
}

#[test]
fn splines_are_as_steep_as_their_tangents() {
    let mut document = Document::new();
    let keys = [
        [[9.0; 3], [0.0; 3], [1.0, 0.0, 0.0]].concat(),
        [[0.0, -2.0, 0.0], [0.0; 3], [9.0; 3]].concat(),
    ];
    animate(&mut document, "translation", "CUBICSPLINE", &[0.0, 2.0], &keys.concat());
    let before = corners(&mut Document::new(), "");
    let after = corners(&mut document, "time = 0.5\n");
    // At a quarter of two seconds: t³ − 2t² + t of the first tangent, t³ − t² of the last.
    let moved = Vec3::new(2.0 * 0.140_625, -2.0 * 2.0 * -0.046_875, 0.0);
    for (before, after) in before.iter().zip(&after) {
        assert!((*before + moved - *after).length() < 1e-6, "{before} {after}");
    }
}

#[test]
fn rotations_and_scales_go_their_own_way() {
    let from = Quat::from_rotation_x(0.3);
    // The longer way around, which is not taken.
    let to = -(Quat::from_rotation_x(0.3) * Quat::from_rotation_y(1.4));
    let mut document = Document::new();
    let values = [from.to_array(), to.to_array()].concat();
    animate(&mut document, "rotation", "LINEAR", &[0.0, 1.0], &values);
    document.json["nodes"][0]["scale"] = json!([2.0, 1.0, 1.0]);
    let turn = DQuat::from_rotation_x(0.3) * DQuat::from_rotation_y(0.35);
    let before = corners(&mut Document::new(), "");
    let after = corners(&mut document, "time = 0.25\n");
    for (before, after) in before.iter().zip(&after) {
        let want = turn * (before.as_dvec3() * glam::DVec3::new(2.0, 1.0, 1.0));
        assert!((want - after.as_dvec3()).length() < 1e-6, "{want} {after}");
    }
}

#[test]
fn weights_of_morph_targets_move() {
    let mut document = Document::new();
    for target in [[1.0, 0.0, 0.0], [0.0, 0.0, 3.0]] {
        let target = document.floats("VEC3", &target.repeat(4));
        let targets = &mut document.json["meshes"][0]["primitives"][0]["targets"];
        match targets {
            Value::Array(targets) => targets.push(json!({"POSITION": target})),
            missing => *missing = json!([{"POSITION": target}]),
        }
    }
    document.json["nodes"][0]["weights"] = json!([7.0, 7.0]);
    animate(&mut document, "weights", "LINEAR", &[0.0, 1.0], &[0.0, 1.0, 1.0, 0.0]);
    let before = corners(&mut Document::new(), "");
    let after = corners(&mut document, "time = 0.75\n");
    for (before, after) in before.iter().zip(&after) {
        assert_eq!(*before + Vec3::new(0.75, 0.0, 0.75), *after);
    }
}

#[test]
fn an_animation_is_chosen_and_what_is_odd_refused() {
    let mut document = Document::new();
    animate(&mut document, "translation", "LINEAR", &[0.0], &[0.0, 0.0, 0.0]);
    animate(&mut document, "translation", "LINEAR", &[0.0], &[1.0, 0.0, 0.0]);
    document.json["animations"][0]["name"] = json!("rest");
    document.json["animations"][1]["name"] = json!("walk");
    for (animation, right) in [("walk", 1.0), ("1", 1.0), ("rest", 0.0), ("0", 0.0)] {
        let keys = format!("time = 3\nanimation = \"{animation}\"\n");
        assert_eq!(stopped(&mut document, &keys).unwrap().halves[1], right, "{animation}");
    }
    for (keys, reason) in [
        (
            "time = 3\n",
            "animation: which one, by name or by number from 0? There are 'rest', 'walk'",
        ),
        ("time = 3\nanimation = \"run\"\n", "none is called 'run': there are 'rest', 'walk'"),
        ("time = 3\nanimation = \"2\"\n", "none is called '2'"),
        ("animation = \"walk\"\n", "only a mesh at a time has one"),
        ("time = nan\n", "must be finite"),
    ] {
        let error = stopped(&mut document, keys).unwrap_err().to_string();
        assert!(error.contains(reason), "{keys}: {error}");
    }
    let error = stopped(&mut Document::new(), "time = 3\n").unwrap_err().to_string();
    assert!(error.contains("animation: the file has none"), "{error}");
    let valid = |document: &mut Document| {
        animate(document, "translation", "LINEAR", &[0.0, 1.0], &[0.0; 6]);
    };
    let changes: [(&str, &str, Value, &str); 7] = [
        ("/samplers/0/interpolation", "", json!("CUBIC"), "interpolation CUBIC is not known"),
        ("/samplers/0/interpolation", "", json!("CUBICSPLINE"), "2 values for 2 keyframes"),
        ("/samplers/0/input", "", json!(99), "no accessor 99"),
        ("/channels/0/sampler", "", json!(9), "no sampler 9"),
        ("/channels/0/target/node", "", json!(9), "no node 9"),
        ("/channels/0/target/path", "", json!(4), "expected a string"),
        ("", "/nodes/0/matrix", json!(glam::Mat4::IDENTITY.to_cols_array()), "with a matrix"),
    ];
    for (within, elsewhere, value, reason) in changes {
        let mut document = Document::new();
        valid(&mut document);
        if elsewhere.is_empty() {
            *document.json["animations"][0].pointer_mut(within).unwrap() = value;
        } else {
            document.json["nodes"][0]["matrix"] = value;
        }
        let error = stopped(&mut document, "time = 0.5\n").unwrap_err().to_string();
        assert!(error.contains(reason) && error.contains("animation 0"), "{reason}: {error}");
    }
    // Times that go back.
    let mut document = Document::new();
    animate(&mut document, "translation", "LINEAR", &[1.0, 0.0], &[0.0; 6]);
    let error = stopped(&mut document, "time = 0.5\n").unwrap_err().to_string();
    assert!(error.contains("must increase"), "{error}");
    // What extensions animate is left out, and said where it could matter.
    let mut document = Document::new();
    let pointer = |path: &str| {
        let pointer = json!({"KHR_animation_pointer": {"pointer": path}});
        json!({"sampler": 0, "target": {"path": "pointer", "extensions": pointer}})
    };
    let channels = json!([pointer("/materials/0/alphaCutoff"), pointer("/cameras/0/yfov")]);
    document.json["animations"] = json!([{"samplers": [], "channels": channels}]);
    let found = stopped(&mut document, "time = 0.5\n").unwrap();
    assert_eq!(found.warnings.len(), 1, "{found:?}");
    assert!(found.warnings[0].contains("animation of /materials/0/alphaCutoff is not applied"));
}
